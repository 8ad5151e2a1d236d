#include "fricid/dynamics/robot_model.hpp"

#include <cmath>
#include <numbers>

#include <fmt/format.h>

#include <Eigen/LU>

#include "fricid/dynamics/couplings.hpp"

namespace fricid::dynamics {

Travel travel_of(const Joint& joint) {
  constexpr double kNobodys = 100;  // [rad or m]
  const bool limited = !joint.continuous && joint.upper > joint.lower;
  if (limited && -joint.lower <= kNobodys && joint.upper <= kNobodys)
    return {joint.lower, joint.upper};
  const double half = slides(joint) ? 1 : std::numbers::pi;
  return {-half, half};
}

double shape_of(const LinearTorque& torque, double q) {
  switch (torque.shape) {
    case LinearTorque::Shape::kConstant:
      return 1;
    case LinearTorque::Shape::kSin:
      return std::sin(torque.k * q);
    case LinearTorque::Shape::kCos:
      return std::cos(torque.k * q);
    case LinearTorque::Shape::kLinear:
      return q;
  }
  return 0;
}

std::vector<std::string> RobotModel::joint_names() const {
  std::vector<std::string> names;
  for (const Joint& joint : joints) names.push_back(joint.name);
  return names;
}

std::vector<std::string> RobotModel::parameter_names() const {
  std::vector<std::string> names;
  for (const Joint& joint : joints)
    for (const char* symbol :
         {"m", "m cx", "m cy", "m cz", "Ixx", "Ixy", "Iyy", "Ixz", "Iyz", "Izz"})
      names.push_back(fmt::format("{} {}", joint.name, symbol));
  for (const Joint& joint : joints) names.push_back(fmt::format("{} Ia", joint.name));
  for (const LinearTorque& torque : linear_torques) names.push_back(torque.name);
  return names;
}

Eigen::MatrixXd RobotModel::joints_of_motors() const {
  return dynamics::joints_of_motors(couplings, n());
}

Eigen::MatrixXd RobotModel::motors_of_joints() const {
  constexpr double kRounding = 1e-14;
  Eigen::MatrixXd C = joints_of_motors();
  if (coupled()) C = C.partialPivLu().inverse().eval();
  return (C.array().abs() > kRounding).select(C, 0);
}

bool is_transmission(const RobotModel& model) { return is_transmission(model.joints_of_motors()); }

void add_linear_torque(RobotModel& model, LinearTorque torque, double c) {
  model.linear_torques.push_back(std::move(torque));
  model.pi.conservativeResize(model.parameter_count());
  model.pi(model.pi.size() - 1) = c;
}

void add_payload(RobotModel& model, const Frame& frame, double mass, const Eigen::Vector3d& com,
                 const Eigen::Matrix3d& inertia) {
  if (frame.link < 0) return;
  const Eigen::Vector3d c = frame.R * com + frame.p;
  const Eigen::Matrix3d about_origin =
      frame.R * inertia * frame.R.transpose() +
      mass * (c.squaredNorm() * Eigen::Matrix3d::Identity() - c * c.transpose());
  auto pi = model.pi.segment<10>(10 * frame.link);
  pi(0) += mass;
  pi.segment<3>(1) += mass * c;
  pi(4) += about_origin(0, 0);
  pi(5) += about_origin(0, 1);
  pi(6) += about_origin(1, 1);
  pi(7) += about_origin(0, 2);
  pi(8) += about_origin(1, 2);
  pi(9) += about_origin(2, 2);
}

}  // namespace fricid::dynamics
