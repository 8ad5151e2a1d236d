#pragma once

#include <string>
#include <vector>

#include "fricid/dynamics/robot_model.hpp"

namespace fricid::scene {

inline std::vector<std::string> joint_names(const dynamics::RobotModel& robot) {
  std::vector<std::string> names;
  for (const dynamics::Joint& joint : robot.joints) names.push_back(joint.name);
  return names;
}

}  // namespace fricid::scene
