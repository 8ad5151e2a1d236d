#pragma once

#include <string>

#include "fricid/dynamics/robot_model.hpp"
#include "fricid/friction/robot_friction.hpp"

namespace fricid::scene {

/// LuGre friction of usual size for robots with gears, from the limits of each joint:
///
///     Fc = 0.06 effort,  Fs = 1.25 Fc,  sigma2 = 0.2 effort / velocity limit,
///     sigma0 = Fs / 0.6 mrad (20 um for a prismatic joint)
///
/// @param where  "file:line" for messages
/// @throws UserError naming a joint without an effort limit
/// @see Waiboer, Aarts & Jonker 2005; Bittencourt & Gunnarsson 2012, for shares of this order
friction::Friction friction_by_effort(const dynamics::RobotModel& robot, const std::string& where);

}  // namespace fricid::scene
