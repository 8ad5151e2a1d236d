// The regression of the rigid body, once its rows and its prior are decided.
#pragma once

#include "rigid_body/dilution.hpp"
#include "rigid_body/regression.hpp"

namespace fricid::estimate {

/// Solves `data` with its friction and, where `options` say so, the prior.
/// @param noise  rows of the noise in `data`
/// @param fit    holds the counts of `stack`
RigidBodyFit solve(const dynamics::RobotModel& robot, std::span<const signals::Recording> sequences,
                   const Regression& data, const NoiseRows& noise, const RigidBodyOptions& options,
                   RigidBodyFit fit);

}  // namespace fricid::estimate
