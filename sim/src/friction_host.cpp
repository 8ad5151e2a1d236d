#include "fricid/sim/friction_host.hpp"

#include "fricid/base/error.hpp"

namespace fricid::sim {

FrictionHost::FrictionHost(const friction::Friction& friction, const MujocoArm& arm)
    : friction_(friction) {
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
}

std::span<const double> FrictionHost::torque(const mjData& data, std::span<const double> tau,
                                             std::span<const double> temperature) {
  read_motion(data);
  for (std::size_t j = 0; j < in_.size(); ++j) {
    in_[j].load = tau[j];
    in_[j].temperature = temperature[j];
  }
  friction_.model.torque<double>(friction_.theta, in_, z_, tau_f_);
  return tau_f_;
}

void FrictionHost::step(const mjData& data, double h) {
  read_motion(data);
  friction_.model.step<double>(friction_.theta, in_, h, z_);
}

}  // namespace fricid::sim
