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

/// How the gradient of a fit moves with the armatures that are held in it (p x held): columns P e
/// sd, P the precision, e of the armature, sd what a nominal value or a guess may be off by. Nobody
/// measured them, although P is tight.
Eigen::MatrixXd held_scores(const dynamics::RobotModel& robot, const RigidBodyOptions& options);

/// Square root of a precision so wide that it only decides what the data leave open.
Eigen::MatrixXd weak_pull(const dynamics::RobotModel& robot, const dynamics::Guesses& guesses);

}  // namespace fricid::estimate
