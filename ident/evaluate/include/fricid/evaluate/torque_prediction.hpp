// Prediction of the motor torque from measured motion, for logs whose open loop means nothing.
#pragma once

#include <vector>

#include "fricid/data/dataset.hpp"
#include "fricid/system/arm.hpp"
#include "fricid/system/driven_friction.hpp"

namespace fricid::evaluate {

/// Predicted motor torque and its error per joint, over the samples with a measured torque.
struct TorquePrediction {
  RowMatrix tau;                       ///< (T, n) predicted [N m]
  RowMatrix tau_f;                     ///< (T, n) friction in it, its constant part too [N m]
  std::vector<double> rmse;            ///< (n) [N m]
  std::vector<double> percent_of_rms;  ///< (n) 100 rmse / rms of the measured torque
  std::vector<double> r2;              ///< (n) 1 - sum e^2 / sum (tau - mean tau)^2
};

/// tau = M(q) a + h(q, v) + tau_f, friction driven by the motion (free run: its state is never
/// corrected by the measured torque, which only says how the first sample was reached, see
/// initial_friction_state). Laws that read the load see the predicted torque, not the
/// measured one: the rigid-body torque first, then once more with the friction found.
/// @param known    the robot before identification, see constant_friction
/// @param q, v, a  zero-phase filtered motion (T, n)
/// @throws UserError when the sizes do not agree
TorquePrediction torque_prediction(const Arm& arm, const dynamics::RobotModel& known,
                                   const data::Dataset& dataset, ConstRowMatrix q, ConstRowMatrix v,
                                   ConstRowMatrix a);

}  // namespace fricid::evaluate
