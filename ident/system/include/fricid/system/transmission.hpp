// Conversion between joint coordinates, used by logs and scores, and motor coordinates, used by the
// dynamics.
#pragma once

#include <Eigen/Core>

#include "fricid/dynamics/robot_model.hpp"
#include "fricid/signals/dataset.hpp"

namespace fricid {

/// Signals over T samples, one row each (T, n), with A of the robot (dynamics::RobotModel):
///
///     q = A m,   tau_m = A' tau_q.
///
/// Without coupled motors they stay unchanged, to the last bit. A missing value (NaN) propagates
/// only to values that depend on it.
class Transmission {
 public:
  explicit Transmission(const dynamics::RobotModel& robot);

  bool coupled() const { return A_.size() > 0; }

  RowMatrix to_motors(ConstRowMatrix q) const;  ///< of positions and their derivatives
  RowMatrix to_joints(ConstRowMatrix m) const;  ///< of positions and their derivatives
  RowMatrix torque_to_motors(ConstRowMatrix tau) const;
  RowMatrix torque_to_joints(ConstRowMatrix tau_m) const;
  signals::Dataset to_motors(signals::Dataset log) const;

  const Eigen::MatrixXd& A() const { return A_; }        ///< empty without couplings
  const Eigen::MatrixXd& inverse() const { return C_; }  ///< empty without couplings

 private:
  Eigen::MatrixXd A_, C_;
};

}  // namespace fricid
