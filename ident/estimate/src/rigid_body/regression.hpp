// The inverse-dynamics model stacked into one linear regression.
#pragma once

#include <span>
#include <vector>

#include "fricid/dynamics/workspace.hpp"
#include "fricid/estimate/rigid_body/least_squares.hpp"

namespace fricid::estimate {

/// tau = rows x + e with x = (pi, Fc, Fv, offset), one row per joint and sample that enters.
struct Regression {
  Eigen::MatrixXd rows;       ///< (N x (p + 3 n))
  Eigen::VectorXd tau;        ///< (N) [N m]
  std::vector<int> joint;     ///< (N)
  std::vector<int> sequence;  ///< (N)
  std::vector<int> sample;    ///< (N) of the sequence
  /// (N) error of tau from what is not known of its timing, `Dataset::torque_delay_sd` [N m]
  Eigen::VectorXd late;
  std::vector<int> passage;  ///< (N) as of `TimeBlocks` of a second, in a short log less
};

/// Stacks the rows that `options` let in, decimated; counts them in `fit`.
/// @param shape  as `rigid_body_least_squares`
Regression stack(const dynamics::RobotModel& robot, std::span<const signals::Recording> sequences,
                 const RigidBodyOptions& options, const FrictionTorques* shape, RigidBodyFit& fit);

/// Regressor Y (n x p) of sample k of a motion.
void regressor_at(const dynamics::RobotModel& robot, dynamics::Workspace<double>& ws,
                  const signals::Motion& motion, int k, Eigen::Ref<Eigen::MatrixXd> Y);

/// Error of a torque from what is not known of its timing: `torque_delay_sd` times its rate.
double late_by(const signals::Recording& recording, int k, int joint);

/// Column of the viscous friction of a joint.
int viscous_column(const dynamics::RobotModel& robot, int joint);

/// Columns of the friction of `stack`, and of what a caller added, that any row excites.
std::vector<int> excited_friction(const dynamics::RobotModel& robot, const Regression& data);

/// Torque residual of the rigid body pi in every sequence, the target of friction fits.
FrictionTorques friction_target(const dynamics::RobotModel& robot, const Eigen::VectorXd& pi,
                                std::span<const signals::Recording> sequences, int jobs);

}  // namespace fricid::estimate
