// MJCF made from a RobotModel, for robots that have only a URDF; MJCF checked against one.
#pragma once

#include <filesystem>
#include <string>

#include "fricid/dynamics/robot_model.hpp"

namespace fricid::sim {

/// MJCF text of a robot: the same tree, inertias, axes and armature, gravity along world -z, one
/// capsule per link as its shape. Nothing collides. Linear torques of the robot are left out.
/// @pre the inertias are physical, as `load_urdf` demands
std::string mjcf_of(const dynamics::RobotModel& robot);

/// Checks that an MJCF can be given the friction of a robot.
/// @throws UserError naming the file and the joint: file not readable, joint missing or of another
///         type, joint with frictionloss or damping
void require_joints(const std::filesystem::path& mjcf, const dynamics::RobotModel& robot);

}  // namespace fricid::sim
