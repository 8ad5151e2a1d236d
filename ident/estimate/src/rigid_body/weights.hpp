// Joints that carry another weight than the robot's file says.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "fricid/dynamics/robot_model.hpp"
#include "fricid/estimate/rigid_body/least_squares.hpp"
#include "fricid/signals/recording.hpp"

namespace fricid::estimate {

/// "s2 (24 N m, 49 by the file)": joints whose torque of gravity is another one than that of the
/// robot's file, root mean square over the recordings, by a quarter of the larger of the two, a
/// tenth of the joint's torque and four standard errors. None of a fit that needed the file.
/// @param robot  as its file has it
std::vector<std::string> other_weights(const dynamics::RobotModel& robot,
                                       std::span<const signals::Recording> recordings,
                                       const RigidBodyFit& fit);

}  // namespace fricid::estimate
