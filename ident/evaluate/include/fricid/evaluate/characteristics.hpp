// Motions that show hysteresis: slow loops through presliding, and reversals.
#pragma once

#include <Eigen/Core>

#include <span>

#include "fricid/signals/matrix.hpp"
#include "fricid/system/driven_friction.hpp"

namespace fricid::evaluate {

/// Displacement from rest over which a friction reaches 90 % of what it reaches in 50 mrad at 10
/// mrad/s, without load: the length of presliding, per joint (n) [rad].
Eigen::VectorXd presliding_length(const friction::Friction& friction);

/// A slow motion through presliding: up, once around the outer loop, and an inner loop on the way
/// back, one leg at a time at constant speed.
struct PreslidingMotion {
  RowMatrix q;    ///< (T, n) [rad]
  RowMatrix v;    ///< (T, n) [rad/s]
  double dt = 0;  ///< [s]
};
/// @param amplitude  of the outer loop, per joint (n) [rad]
PreslidingMotion presliding_motion(const Eigen::VectorXd& amplitude);

/// That motion through the presliding of several frictions: 1.5 times the longest of their lengths
/// at each joint, at least 0.15 mrad.
/// @pre `frictions` is not empty
PreslidingMotion presliding_motion_through(std::span<const friction::Friction> frictions);

/// Torque of a friction along that motion, from rest and without load (T, n) [N m].
RowMatrix presliding_loop(const friction::Friction& friction, const PreslidingMotion& motion);

/// Row of the slowest reversal of a joint that moves faster than 0.15 rad/s in opposite directions
/// 0.15 s before and after it; -1: none.
/// @param v  (T) [rad/s], sampled every dt [s]
Eigen::Index slowest_reversal(const Eigen::VectorXd& v, double dt);
inline constexpr double kAroundReversal = 0.15;  ///< [s]

}  // namespace fricid::evaluate
