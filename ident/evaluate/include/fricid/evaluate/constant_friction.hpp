// The part of an identified friction torque that a robot model carries as a constant.
#pragma once

#include <Eigen/Core>

#include "fricid/dynamics/robot_model.hpp"

namespace fricid::evaluate {

/// Constant part of the friction: constant torques (LinearTorque::Shape::kConstant) of `robot` less
/// those of `known`, the robot before identification. Friction that differs between the directions
/// of motion has such a part; laws that are odd in velocity cannot represent it.
/// @return torque per joint (n) [N m]
Eigen::RowVectorXd constant_friction(const dynamics::RobotModel& robot,
                                     const dynamics::RobotModel& known);

}  // namespace fricid::evaluate
