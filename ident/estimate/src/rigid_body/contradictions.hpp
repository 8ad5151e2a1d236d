// Where the torques of an arm's joints contradict each other by one rigid body.
#pragma once

#include <span>
#include <vector>

#include "fricid/dynamics/robot_model.hpp"
#include "fricid/estimate/fault.hpp"
#include "fricid/estimate/options/rigid_body.hpp"
#include "fricid/estimate/rigid_body/least_squares.hpp"
#include "fricid/signals/recording.hpp"

namespace fricid::estimate {

/// What explains far more of the torque than the robot as it is given: columns that are those of
/// coupled motors and were taken for those of joints, or the other way round; time in which the
/// motors do not drive the arm; what differs between logs or changes within them; else springs of
/// joints (a torque of q, sin q and cos q beside gravity), or factors of the torque of joints.
/// @param fit  of the torque as it is read; nothing is claimed where it needed a prior
std::vector<Fault> find_contradictions(const dynamics::RobotModel& robot,
                                       std::span<const signals::Recording> recordings,
                                       const RigidBodyOptions& options, const RigidBodyFit& fit);

/// Of these what differs between recordings or changes within them: zeros of joints, constant
/// torques and factors of the torque, bodies, friction, a load.
std::vector<Fault> find_differences(const dynamics::RobotModel& robot,
                                    std::span<const signals::Recording> recordings,
                                    const RigidBodyOptions& options);

}  // namespace fricid::estimate
