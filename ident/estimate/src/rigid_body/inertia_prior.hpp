// Prior of a robot's parameters.
#pragma once

#include "fricid/estimate/rigid_body/least_squares.hpp"

namespace fricid::estimate {

/// Standard deviation, before any data, of friction over the torque of the motor [1].
constexpr double kUsualGrowth = 0.1;

/// Whether the nominal values enter a fit as a prior.
inline bool has_prior(const RigidBodyOptions& options) {
  return options.prior.use || !options.held_armatures.empty();
}

/// Precision (p x p) of CAD values and coefficients of linear torques; of the held armatures alone,
/// the rest wide, unless `prior.use`.
Eigen::MatrixXd prior_precision(const dynamics::RobotModel& robot, const RigidBodyOptions& options);

/// Square root of a precision so wide that it only decides what the data leave open.
Eigen::MatrixXd weak_pull(const dynamics::RobotModel& robot, const dynamics::Guesses& guesses);

}  // namespace fricid::estimate
