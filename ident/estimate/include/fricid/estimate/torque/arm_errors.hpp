// How far friction and rigid body that were fitted together may err.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "fricid/estimate/friction/motion_errors.hpp"
#include "fricid/estimate/torque/arm_torque_fit.hpp"
#include "fricid/estimate/windows/window_refinement.hpp"

namespace fricid::estimate {

/// How far a fit may err.
struct ArmErrors {
  /// Root S of the covariance S S' of (pi, theta): a column per block, one per armature that was
  /// held, those of noise in the regressor, then one per joint of what its motion makes; empty:
  /// unknown.
  Eigen::MatrixXd root;
  Eigen::Index before_motion = 0;  ///< columns before those of the motion
  std::vector<Arm> draws;          ///< arms that the same data might as well have given
};

/// Errors by a jackknife over blocks of a second, all joints together, in one step each,
///
///     S = dx/dc (d_b - mean d)_b sqrt((m - 1)/m),   d_b = (H + 1 - B'B)^-1 B'e,
///
/// c being pi and the coordinates of friction, with H the matrix of a step and B, e the Jacobian
/// and the residual of block b of m, over sigma: residuals of a second depend on each other, what
/// the model misses counts like noise, and a block that alone holds what is known of a parameter
/// shows it. The same second of recordings of one motion is one block: what the model misses there
/// it misses in all. The ridge of one datum keeps what the data leave open within its own size in
/// the draws; a parameter of friction of which they tell less has the inverse root of that as
/// an error too, so that a coefficient of nearly nothing is not known to nearly nothing. A held
/// armature is no better known than before: it adds H^-1 times the score of its standard deviation.
/// Encoder noise pulls the rigid body to zero where the motion is hardly above it, `dilution_root`.
/// The last columns are M = H^-1 J'm with m the error that the motion of a joint makes
/// (`MotionErrors`). Draws are those of the blocks alone, S w, w ~ N(0, 1), each halved until the
/// objective exceeds its quadratic by no more than the quadratic part: springs of a bank that stand
/// for each other are straight lines in no coordinates.
/// @param motion  of the recordings of `data`
/// @param count   of draws
/// @return nothing where there are fewer than ten blocks
ArmErrors arm_errors(const ArmTorqueData& data, const MotionErrors& motion, const Arm& fitted,
                     const ArmTorqueOptions& options, int count, std::uint64_t seed, int jobs);

/// What the torque says of a fitted arm, less what its motion may have changed: the objective about
/// c with (H^-1 + M M')^-1 for H, see `arm_errors`.
TorquePull torque_pull(const ArmTorqueData& data, const MotionErrors& motion, const Arm& fitted,
                       const ArmTorqueOptions& options, int jobs);

}  // namespace fricid::estimate
