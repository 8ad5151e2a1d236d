// Other directions of gravity that explain the torque of a log.
#pragma once

#include <string>
#include <vector>

#include "fricid/dynamics/robot_model.hpp"
#include "sight.hpp"

namespace fricid::doctor {

/// Another mount that explains more of the torque, and what it has to gain to be believed.
struct OtherMount {
  dynamics::RobotModel robot;
  double belief;  ///< log of the factor, see `kBelief`
};

/// The robot on a slope, on its head or on a side, whichever explains most of the torque as it
/// stands; those that are the mount as it is stated, within a few degrees, are left out. Last,
/// without gravity where that explains more still: drivers take it off.
std::vector<OtherMount> other_mounts(const dynamics::RobotModel& robot, const Sight& sight);

/// Gravity turned about the axis of all joints is the same as a wrong zero of the first.
std::string zero_instead(const dynamics::RobotModel& robot, const Eigen::Vector3d& gravity);

}  // namespace fricid::doctor
