#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "fricid/dynamics/robot_model.hpp"

namespace fricid::dynamics {

/// Base parameters: the identifiable combinations of the standard parameters (Gautier 1991),
///     Y(q, v, a) pi = Y(q, v, a)[:, columns] pi_b,    pi_b = K pi.
/// Found by column-pivoted QR of regressors at random states within the limits (fixed seed).
/// b base parameters of p standard ones.
struct BaseParameters {
  std::vector<int> columns;         ///< chosen independent columns of Y, ascending (b)
  Eigen::MatrixXd K;                ///< (b x p); K[:, columns] = I
  std::vector<std::string> names;   ///< symbolic groupings, e.g. "m2 cx + 0.315 m3 + ..."
  std::vector<int> unidentifiable;  ///< standard parameters without effect on the torque
  double gap = 0;                   ///< smallest kept over largest dropped pivot of R [1]
};
BaseParameters base_parameters(const RobotModel& model);

}  // namespace fricid::dynamics
