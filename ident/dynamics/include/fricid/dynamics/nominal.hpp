// What a robot's file leaves out: joints that nothing resists are refused.
#pragma once

#include <Eigen/Core>
#include <string>

#include "fricid/dynamics/robot_model.hpp"

namespace fricid::dynamics {

/// Usual armature of each joint (n) [kg m^2]: what its effort limit brings to its velocity limit in
/// 0.03 s, which small and large industrial arms are within a factor of 4 of; without limits, a
/// third of the largest inertia that the links have about the joint.
Eigen::VectorXd usual_armature(const RobotModel& robot);

/// @throws UserError naming `source`, link and joint, when a joint accelerates without any torque
/// in every pose, other joints free: the mass matrix is singular
void require_inertia(const RobotModel& robot, const std::string& source);

}  // namespace fricid::dynamics
