// MJCF made from a RobotModel, for robots that have only a URDF.
#pragma once

#include <string>

#include "fricid/dynamics/robot_model.hpp"

namespace fricid::sim {

/// MJCF text of a robot: the same tree, inertias, axes and armature, gravity along world -z, one
/// capsule per link as its shape. Nothing collides. Linear torques of the robot are left out.
/// @pre the inertias are physical, as `load_urdf` demands
std::string mjcf_of(const dynamics::RobotModel& robot);

}  // namespace fricid::sim
