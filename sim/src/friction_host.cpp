#include "fricid/sim/friction_host.hpp"

#include "fricid/base/error.hpp"

namespace fricid::sim {
namespace {

// One address per joint.
template <class AddressOf>
std::vector<int> addresses(const MujocoArm& arm, AddressOf address_of) {
  std::vector<int> all;
  for (int j = 0; j < arm.n(); ++j) all.push_back(address_of(j));
  return all;
}

}  // namespace

FrictionHost::FrictionHost(const friction::Friction& friction, const MujocoArm& arm,
                           const dynamics::RobotModel& robot)
    : FrictionHost(friction, robot, addresses(arm, [&](int j) { return arm.qpos(j); }),
                   addresses(arm, [&](int j) { return arm.dof(j); })) {}

FrictionHost::FrictionHost(const friction::Friction& friction, const dynamics::RobotModel& robot,
                           std::vector<int> qpos, std::vector<int> dof)
    : friction_(friction), qpos_(std::move(qpos)), dof_(std::move(dof)), motors_(robot) {
  if (friction.model.joint_count() != static_cast<int>(dof_.size()))
    throw UserError("friction has {} joints, the arm has {}", friction.model.joint_count(),
                    dof_.size());
  in_.resize(dof_.size());
  tau_f_.resize(dof_.size());
  z_.assign(static_cast<std::size_t>(friction.model.state_size()), 0.0);
}

void FrictionHost::read(const mjData& data, std::span<const double> tau,
                        std::span<const double> temperature) {
  for (std::size_t j = 0; j < in_.size(); ++j)
    in_[j] = {data.qpos[qpos_[j]], data.qvel[dof_[j]], tau[j], temperature[j]};
  if (motors_.coupled()) convert_to_motors(tau);
}

void FrictionHost::convert_to_motors(std::span<const double> tau) {
  const auto n = std::ssize(in_);
  RowMatrix motion(2, n);
  for (Eigen::Index j = 0; j < n; ++j)
    motion.col(j) << in_[static_cast<std::size_t>(j)].q, in_[static_cast<std::size_t>(j)].v;
  motion = motors_.to_motors(motion);
  const RowMatrix load = motors_.torque_to_motors(Eigen::Map<const RowMatrix>(tau.data(), 1, n));
  for (Eigen::Index j = 0; j < n; ++j) {
    friction::Input<double>& motor = in_[static_cast<std::size_t>(j)];
    motor.q = motion(0, j);
    motor.v = motion(1, j);
    motor.load = load(0, j);
  }
}

std::span<const double> FrictionHost::torque(const mjData& data, std::span<const double> tau,
                                             std::span<const double> temperature) {
  read(data, tau, temperature);
  friction_.model.torque<double>(friction_.theta, in_, z_, tau_f_);
  if (motors_.coupled()) {
    Eigen::Map<RowMatrix> tau_f(tau_f_.data(), 1, std::ssize(tau_f_));
    tau_f = motors_.torque_to_joints(tau_f);
  }
  return tau_f_;
}

void FrictionHost::step(const mjData& data, std::span<const double> tau,
                        std::span<const double> temperature, double h) {
  read(data, tau, temperature);
  friction_.model.step<double>(friction_.theta, in_, h, z_);
}

}  // namespace fricid::sim
