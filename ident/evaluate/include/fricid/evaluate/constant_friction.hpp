// The part of an identified friction torque that a robot model carries as a constant.
#pragma once

#include <Eigen/Core>

#include "fricid/dynamics/robot_model.hpp"

namespace fricid::evaluate {

/// Friction that differs between the directions of motion has a constant part, which no odd law can
/// hold: a fit finds it as a constant torque of the joint (LinearTorque::Shape::kConstant). This is
/// what the constants of `robot` add to those of `known`, the robot before identification; it
/// counts as friction.
/// @return torque per joint (n) [N m]
Eigen::RowVectorXd constant_friction(const dynamics::RobotModel& robot,
                                     const dynamics::RobotModel& known);

}  // namespace fricid::evaluate
