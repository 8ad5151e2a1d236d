#include "fricid/sim/friction_host.hpp"

#include <algorithm>

#include "fricid/base/error.hpp"
#include "fricid/friction/same_structure.hpp"

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
  if (!friction.model.has_whole()) make_lanes();
}

void FrictionHost::make_lanes() {
  const friction::RobotFriction& model = friction_.model;
  for (int j = 0; j < model.joint_count(); ++j) {
    const friction::JointSpec& joint = model.joints()[static_cast<std::size_t>(j)];
    if (joint.laws.empty()) continue;
    auto found = std::ranges::find_if(lanes_, [&](const Lanes& lanes) {
      return lanes.joints.size() < PackD::kLanes && same_structure(lanes.one.joints()[0], joint);
    });
    if (found == lanes_.end()) {
      friction::RobotFriction one({joint});
      const auto size = [](int n) { return static_cast<std::size_t>(n); };
      lanes_.push_back({.one = one,
                        .joints = {},
                        .theta = std::vector<PackD>(size(one.parameter_count())),
                        .z = std::vector<PackD>(size(one.state_size())),
                        .in = {}});
      found = lanes_.end() - 1;
    }
    // this joint from its lane on: the next ones overwrite theirs
    const double* theta = friction_.theta.data() + model.parameter_begin(j);
    for (std::size_t i = 0; i < found->theta.size(); ++i)
      for (int lane = static_cast<int>(found->joints.size()); lane < PackD::kLanes; ++lane)
        found->theta[i].set(lane, theta[i]);
    found->joints.push_back(j);
  }
}

void FrictionHost::gather(Lanes& lanes) const {
  for (int lane = 0; lane < PackD::kLanes; ++lane) {
    const int joint =
        lanes.joints[std::min(static_cast<std::size_t>(lane), lanes.joints.size() - 1)];
    const friction::Input<double>& in = in_[static_cast<std::size_t>(joint)];
    lanes.in.q.set(lane, in.q);
    lanes.in.v.set(lane, in.v);
    lanes.in.load.set(lane, in.load);
    lanes.in.temperature.set(lane, in.temperature);
    const double* z = z_.data() + friction_.model.state_begin(joint);
    for (std::size_t i = 0; i < lanes.z.size(); ++i) lanes.z[i].set(lane, z[i]);
  }
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
  if (friction_.model.has_whole())
    friction_.model.torque<double>(friction_.theta, in_, z_, tau_f_);
  else
    std::ranges::fill(tau_f_, 0.0);
  for (Lanes& lanes : lanes_) {
    gather(lanes);
    PackD tau_f;
    lanes.one.torque<PackD>(lanes.theta, {&lanes.in, 1}, lanes.z, {&tau_f, 1});
    for (std::size_t lane = 0; lane < lanes.joints.size(); ++lane)
      tau_f_[static_cast<std::size_t>(lanes.joints[lane])] = tau_f[static_cast<int>(lane)];
  }
  if (motors_.coupled()) {
    Eigen::Map<RowMatrix> tau_f(tau_f_.data(), 1, std::ssize(tau_f_));
    tau_f = motors_.torque_to_joints(tau_f);
  }
  return tau_f_;
}

void FrictionHost::step(const mjData& data, std::span<const double> tau,
                        std::span<const double> temperature, double h) {
  read(data, tau, temperature);
  if (friction_.model.has_whole()) friction_.model.step<double>(friction_.theta, in_, h, z_);
  for (Lanes& lanes : lanes_) {
    gather(lanes);
    lanes.one.step<PackD>(lanes.theta, {&lanes.in, 1}, h, lanes.z);
    for (std::size_t lane = 0; lane < lanes.joints.size(); ++lane) {
      double* z = z_.data() + friction_.model.state_begin(lanes.joints[lane]);
      for (std::size_t i = 0; i < lanes.z.size(); ++i) z[i] = lanes.z[i][static_cast<int>(lane)];
    }
  }
}

}  // namespace fricid::sim
