#include "rigid_body/regression_start.hpp"

#include <algorithm>
#include <utility>

#include "fricid/dynamics/nominal.hpp"

namespace fricid::estimate {
namespace {

/// The robot that is fitted: a constant torque at every joint that has none takes up sensor
/// offsets and friction that differs between the directions, which no odd law can represent.
dynamics::RobotModel with_offsets(dynamics::RobotModel robot) {
  using dynamics::LinearTorque;
  for (int j = 0; j < robot.n(); ++j) {
    const bool has_one = std::any_of(
        robot.linear_torques.begin(), robot.linear_torques.end(), [&](const LinearTorque& torque) {
          return torque.joint == j && torque.shape == LinearTorque::Shape::kConstant;
        });
    if (has_one) continue;
    LinearTorque offset;
    offset.name = robot.joints[static_cast<std::size_t>(j)].name + " 1";
    offset.joint = j;
    offset.shape = LinearTorque::Shape::kConstant;
    dynamics::add_linear_torque(robot, offset);
  }
  return robot;
}

}  // namespace

RegressionStart start_of_regression(const dynamics::RobotModel& robot, RigidBodyOptions options) {
  dynamics::Nominal nominal = dynamics::complete(robot);
  options.guesses = std::move(nominal.guesses);
  options.offset = false;  // the robot has them
  return {with_offsets(std::move(nominal.robot)), std::move(options)};
}

}  // namespace fricid::estimate
