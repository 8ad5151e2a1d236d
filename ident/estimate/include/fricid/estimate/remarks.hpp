// What the parameters of a fit do not say though they look as if they did.
#pragma once

#include <span>
#include <vector>

#include "fricid/data/fit_file.hpp"
#include "fricid/friction/robot_friction.hpp"

namespace fricid::estimate {

/// Remarks on stiffness that filter and samples of the motion may have changed by a quarter, and on
/// static friction below half of that of sliding.
/// @param joints  of `friction`, as fitted
std::vector<data::FittedRemark> remarks_on(std::span<const data::FittedJoint> joints,
                                           const friction::RobotFriction& friction);

}  // namespace fricid::estimate
