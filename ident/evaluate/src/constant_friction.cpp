#include "fricid/evaluate/constant_friction.hpp"

namespace fricid::evaluate {
namespace {

void add_constants(const dynamics::RobotModel& robot, double sign, Eigen::RowVectorXd& sum) {
  for (std::size_t k = 0; k < robot.linear_torques.size(); ++k) {
    const dynamics::LinearTorque& torque = robot.linear_torques[k];
    if (torque.shape != dynamics::LinearTorque::Shape::kConstant) continue;
    sum[torque.joint] += sign * robot.pi[robot.linear_begin() + static_cast<Eigen::Index>(k)];
  }
}

}  // namespace

Eigen::RowVectorXd constant_friction(const dynamics::RobotModel& robot,
                                     const dynamics::RobotModel& known) {
  Eigen::RowVectorXd sum = Eigen::RowVectorXd::Zero(robot.n());
  add_constants(robot, 1, sum);
  add_constants(known, -1, sum);
  return sum;
}

}  // namespace fricid::evaluate
