// Time in which the motors do not hold or drive the arm.
#pragma once

#include <span>
#include <vector>

#include "fricid/dynamics/robot_model.hpp"
#include "fricid/estimate/fault.hpp"
#include "fricid/estimate/options/rigid_body.hpp"
#include "fricid/estimate/rigid_body/least_squares.hpp"
#include "fricid/signals/recording.hpp"

namespace fricid::estimate {

/// Stretches of logs that are none of a driven arm: it stands, and the torque is off what holds it
/// by more than friction can bear (a brake, a stop); or it moves, and every torque is zero (drives
/// that are off, a hand).
std::vector<Fault> find_undriven(const dynamics::RobotModel& robot,
                                 std::span<const signals::Recording> recordings,
                                 const RigidBodyOptions& options, const RigidBodyFit& fit);

}  // namespace fricid::estimate
