// The identified robot as MJCF.
#pragma once

#include <string>
#include <vector>

#include "fricid/base/xml.hpp"
#include "fricid/data/model_file.hpp"

namespace fricid::deploy {

/// What an MJCF has beyond the rigid body.
struct MjcfExtras {
  Xml head = {};  ///< before <mujoco>
  std::vector<Xml> motor_attributes =
      {};  ///< (n) of the joint, or of the tendon of a coupled motor
  Xml tendons = {};
  Xml rest = {};  ///< further elements of <mujoco>
};

/// @throws UserError when an inertia is not physical
std::string mjcf_text(const data::ModelFile& model, const MjcfExtras& extras);

/// Whether the angle of a motor is that of its joint.
bool turns_alone(const dynamics::RobotModel& robot, int motor);

/// Name of the tendon whose length is the angle of a motor that does not turn alone.
std::string motor_name(const dynamics::RobotModel& robot, int motor);

/// The content of a fixed tendon whose length is the angle of a motor.
Xml motor_angle(const dynamics::RobotModel& robot, int motor);

}  // namespace fricid::deploy
