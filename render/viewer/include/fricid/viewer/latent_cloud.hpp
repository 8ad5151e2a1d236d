// The memory of a joint's friction, as a cloud of its latent states.
#pragma once

#include <Eigen/Core>

#include "fricid/system/driven_friction.hpp"

namespace fricid::viewer {

/// One joint along a motion, T samples.
struct JointMotion {
  double dt = 0;          ///< [s]
  RowMatrix q, v, load;   ///< (T, 1) [rad], [rad/s], torque through the gear [N m]
  RowMatrix temperature;  ///< (T, 1) [K], or empty for room temperature
  RowMatrix z;            ///< (T, L) friction states along it
};

/// Copies of one friction that start in different states and are driven by the same motion from
/// t - age to t. The spread that remains at t is the memory of the motion before.
struct LatentCloud {
  RowMatrix from, to;             ///< (N, L) friction states at t - age and at t
  Eigen::VectorXd from_tau, tau;  ///< (N) their friction torques then [N m]
  Eigen::RowVectorXd state;       ///< (L) of `motion` itself at t
  double state_tau = 0;           ///< its friction torque [N m]
};

/// The cloud at sample `row` of a motion. The initial states are drawn from those along the whole
/// motion.
/// @param friction  of this joint alone
/// @param age       [s], rounded to samples; limited by the start of the motion
/// @pre motion holds at least one sample
LatentCloud latent_cloud(const friction::Friction& friction, const JointMotion& motion, int row,
                         double age, int copies);

/// Spread of a torque: root mean square distance from the mean [N m].
double spread(const Eigen::VectorXd& tau);

}  // namespace fricid::viewer
