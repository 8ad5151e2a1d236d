// What a regression begins with, in a fit and before it.
#pragma once

#include "fricid/estimate/rigid_body/least_squares.hpp"

namespace fricid::estimate {

/// A robot and options as the regression of a fit takes them.
struct RegressionStart {
  dynamics::RobotModel robot;
  RigidBodyOptions options;
};

/// Guesses what the robot's file leaves out (`dynamics::complete`), and makes the constant torque
/// of every joint a parameter of the robot: below a vertical sliding joint masses are one too.
RegressionStart start_of_regression(const dynamics::RobotModel& robot, RigidBodyOptions options);

}  // namespace fricid::estimate
