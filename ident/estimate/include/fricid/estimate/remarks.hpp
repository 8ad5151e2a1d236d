// What the parameters of a fit do not say though they look as if they did.
#pragma once

#include <span>
#include <vector>

#include "fricid/data/fit_file.hpp"
#include "fricid/estimate/torque/left_torque.hpp"
#include "fricid/friction/robot_friction.hpp"

namespace fricid::estimate {

/// Remarks on stiffness that filter and samples of the motion may have changed by a quarter, on
/// static friction below half of that of sliding, or that falls within less than the least Stribeck
/// velocity, and on a fifth of what is left of a torque that goes with the joint's own position, or
/// is friction at one place of it, or two fifths that bend with the torque.
/// @param joints  of `friction`, as fitted
/// @param waves, bends, spots  per joint; empty: none were looked for
std::vector<data::FittedRemark> remarks_on(std::span<const data::FittedJoint> joints,
                                           const friction::RobotFriction& friction,
                                           std::span<const PositionWave> waves = {},
                                           std::span<const TorqueBend> bends = {},
                                           std::span<const TightSpot> spots = {});

}  // namespace fricid::estimate
