#include "fricid/sim/friction_host.hpp"

#include "fricid/base/error.hpp"

namespace fricid::sim {

FrictionHost::FrictionHost(const friction::Friction& friction, const MujocoArm& arm,
                           const dynamics::RobotModel& robot)
    : friction_(friction), motors_(robot) {
  if (friction.model.joint_count() != arm.n())
    throw UserError("friction has {} joints, the arm has {}", friction.model.joint_count(),
                    arm.n());
  for (int j = 0; j < arm.n(); ++j) {
    qpos_.push_back(arm.qpos(j));
    dof_.push_back(arm.dof(j));
  }
  in_.resize(dof_.size());
  tau_f_.resize(dof_.size());
  z_.assign(static_cast<std::size_t>(friction.model.state_size()), 0.0);
}

void FrictionHost::read_motion(const mjData& data) {
  for (std::size_t j = 0; j < in_.size(); ++j) {
    in_[j].q = data.qpos[qpos_[j]];
    in_[j].v = data.qvel[dof_[j]];
  }
  if (!motors_.coupled()) return;
  RowMatrix motion(2, std::ssize(in_));
  for (std::size_t j = 0; j < in_.size(); ++j)
    motion.col(static_cast<Eigen::Index>(j)) << in_[j].q, in_[j].v;
  motion = motors_.to_motors(motion);
  for (std::size_t j = 0; j < in_.size(); ++j) {
    in_[j].q = motion(0, static_cast<Eigen::Index>(j));
    in_[j].v = motion(1, static_cast<Eigen::Index>(j));
  }
}

std::span<const double> FrictionHost::torque(const mjData& data, std::span<const double> tau,
                                             std::span<const double> temperature) {
  read_motion(data);
  for (std::size_t j = 0; j < in_.size(); ++j) {
    in_[j].load = tau[j];
    in_[j].temperature = temperature[j];
  }
  const auto n = std::ssize(in_);
  if (motors_.coupled()) {
    const RowMatrix load = motors_.torque_to_motors(Eigen::Map<const RowMatrix>(tau.data(), 1, n));
    for (std::size_t j = 0; j < in_.size(); ++j)
      in_[j].load = load(0, static_cast<Eigen::Index>(j));
  }
  friction_.model.torque<double>(friction_.theta, in_, z_, tau_f_);
  if (motors_.coupled()) {
    Eigen::Map<RowMatrix> tau_f(tau_f_.data(), 1, n);
    tau_f = motors_.torque_to_joints(tau_f);
  }
  return tau_f_;
}

void FrictionHost::step(const mjData& data, double h) {
  read_motion(data);
  friction_.model.step<double>(friction_.theta, in_, h, z_);
}

}  // namespace fricid::sim
