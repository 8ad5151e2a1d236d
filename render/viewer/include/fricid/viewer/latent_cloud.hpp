// What a joint's friction remembers, as a cloud of its latent states.
#pragma once

#include <Eigen/Core>

#include "fricid/system/driven_friction.hpp"

namespace fricid::viewer {

/// One joint along a motion, T samples.
struct JointMotion {
  double dt = 0;          ///< [s]
  RowMatrix q, v, load;   ///< (T, 1) [rad], [rad/s], torque through the gear [N m]
  RowMatrix temperature;  ///< (T, 1) [K], or empty for room temperature
  RowMatrix z;            ///< (T, L) friction states met on it
};

/// Copies of one friction that begin apart and are driven by the same motion from t - age to t.
/// What of their beginnings the motion has made them forget is gone; the width that is left is
/// memory.
struct LatentCloud {
  RowMatrix from, to;             ///< (N, L) friction states at t - age and at t
  Eigen::VectorXd from_tau, tau;  ///< (N) their friction torques then [N m]
  Eigen::RowVectorXd state;       ///< (L) of `motion` itself at t
  double state_tau = 0;           ///< its friction torque [N m]
};

/// The friction of one joint alone; a law of the whole robot is left out.
friction::Friction friction_of_joint(const friction::Friction& friction, int joint);

/// The cloud at sample `row` of a motion. The copies begin in states drawn from those that the
/// whole motion meets, so in any units and number they are such as occur.
/// @param friction  of this joint alone
/// @param age       [s], rounded to samples; shorter where the motion begins later
/// @pre motion holds at least one sample
LatentCloud latent_cloud(const friction::Friction& friction, const JointMotion& motion, int row,
                         double age, int copies);

/// Spread of a torque: root mean square distance from the mean [N m].
double spread(const Eigen::VectorXd& tau);

}  // namespace fricid::viewer
