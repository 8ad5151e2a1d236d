// A model file as the prior of another fit (`model.prior` of a scene).
#pragma once

#include <string>

#include "fricid/dynamics/robot_model.hpp"
#include "fricid/system/arm.hpp"

namespace fricid::estimate {

/// The arm of a model file that was fitted to a robot like `robot`; its ripples, which have other
/// phases in each arm, without amplitude.
/// @throws UserError when it is another arm, or its friction no sum of laws of its joints
Arm load_prior(const std::string& file, const dynamics::RobotModel& robot);

}  // namespace fricid::estimate
