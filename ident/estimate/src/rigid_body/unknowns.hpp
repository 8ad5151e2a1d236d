// What a regression of the rigid body solves for, and what is known of it beforehand.
#pragma once

#include <vector>

#include "rigid_body/regression.hpp"

namespace fricid::estimate {

/// Columns of `full` listed in `columns`.
Eigen::MatrixXd pick(const Eigen::MatrixXd& full, const std::vector<int>& columns);

/// Base parameters, or all standard parameters under a prior; then the friction that any row
/// excites, growth with the load last.
struct Unknowns {
  std::vector<int> columns, friction;  ///< of the regression; friction is the end of columns
  Eigen::MatrixXd prior_information;
  Eigen::VectorXd prior_mean;
  /// (n x columns of the regression) share of the rms torque of each joint that a unit of each
  /// unknown makes
  Eigen::MatrixXd shares;

  Eigen::Index head() const { return std::ssize(columns) - std::ssize(friction); }
};

Unknowns unknowns_of(const dynamics::RobotModel& robot, const Regression& data,
                     const RigidBodyOptions& options);

}  // namespace fricid::estimate
