#include "fricid/sim/friction_host.hpp"

#include <algorithm>
#include <cstring>
#include <utility>

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

// The pack of of(lane), made in a register.
template <class Of>
[[gnu::always_inline]] inline PackD in_lanes(const Of& of) {
  return [&]<std::size_t... lane>(std::index_sequence<lane...>) {
    return PackD(PackD::Vector{of(lane)...});
  }
  (std::make_index_sequence<PackD::kLanes>());
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
      return lanes.size < PackD::kLanes && same_structure(lanes.one.joints()[0], joint);
    });
    if (found == lanes_.end()) {
      friction::RobotFriction one({joint});
      const auto size = [](int n) { return static_cast<std::size_t>(n); };
      lanes_.push_back({.one = one,
                        .theta = std::vector<PackD>(size(one.parameter_count())),
                        .z = std::vector<PackD>(size(one.state_size())),
                        .in = {}});
      found = lanes_.end() - 1;
    }
    // this joint from its lane on: the next ones overwrite theirs
    const double* theta = friction_.theta.data() + model.parameter_begin(j);
    for (int lane = found->size; lane < PackD::kLanes; ++lane) {
      found->joint[static_cast<std::size_t>(lane)] = static_cast<std::size_t>(j);
      found->state[static_cast<std::size_t>(lane)] = static_cast<std::size_t>(model.state_begin(j));
      for (std::size_t i = 0; i < found->theta.size(); ++i) found->theta[i].set(lane, theta[i]);
    }
    ++found->size;
  }
}

void FrictionHost::gather(Lanes& lanes) const {
  const auto of_joints = [&](auto member) {
    return in_lanes([&](std::size_t lane) { return in_[lanes.joint[lane]].*member; });
  };
  using Input = friction::Input<double>;
  lanes.in = {of_joints(&Input::q), of_joints(&Input::v), of_joints(&Input::load),
              of_joints(&Input::temperature)};
  for (std::size_t i = 0; i < lanes.z.size(); ++i)
    lanes.z[i] = in_lanes([&](std::size_t lane) { return z_[lanes.state[lane] + i]; });
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

void FrictionHost::remember(bool torque_too) {
  last_in_ = in_;
  last_z_ = z_;
  knows_torque_ = torque_too;
}

bool FrictionHost::is_remembered() const {
  const auto same = [](const auto& a, const auto& b) {
    return a.size() == b.size() &&
           (a.empty() || std::memcmp(a.data(), b.data(), a.size() * sizeof(a[0])) == 0);
  };
  return same(in_, last_in_) && same(z_, last_z_);
}

void FrictionHost::set_torque(const Lanes& lanes, PackD tau_f) {
  for (int lane = 0; lane < lanes.size; ++lane)
    tau_f_[lanes.joint[static_cast<std::size_t>(lane)]] = tau_f[lane];
}

void FrictionHost::convert_to_joints() {
  if (!motors_.coupled()) return;
  Eigen::Map<RowMatrix> tau_f(tau_f_.data(), 1, std::ssize(tau_f_));
  tau_f = motors_.torque_to_joints(tau_f);
}

std::span<const double> FrictionHost::torque(const mjData& data, std::span<const double> tau,
                                             std::span<const double> temperature) {
  read(data, tau, temperature);
  const bool remembered = is_remembered();
  if (remembered && knows_torque_) return tau_f_;
  foresees_ = remembered;
  if (friction_.model.has_whole())
    friction_.model.torque<double>(friction_.theta, in_, z_, tau_f_);
  else
    std::ranges::fill(tau_f_, 0.0);
  for (Lanes& lanes : lanes_) {
    gather(lanes);
    PackD tau_f;
    lanes.one.torque<PackD>(lanes.theta, {&lanes.in, 1}, lanes.z, {&tau_f, 1});
    set_torque(lanes, tau_f);
  }
  convert_to_joints();
  remember(true);
  return tau_f_;
}

void FrictionHost::step(const mjData& data, std::span<const double> tau,
                        std::span<const double> temperature, double h) {
  read(data, tau, temperature);
  if (foresees_) std::ranges::fill(tau_f_, 0.0);
  if (friction_.model.has_whole()) {
    if (foresees_)
      friction_.model.step_torque<double>(friction_.theta, in_, h, z_, tau_f_);
    else
      friction_.model.step<double>(friction_.theta, in_, h, z_);
  }
  for (Lanes& lanes : lanes_) {
    gather(lanes);
    if (foresees_) {
      PackD tau_f;
      lanes.one.step_torque<PackD>(lanes.theta, {&lanes.in, 1}, h, lanes.z, {&tau_f, 1});
      set_torque(lanes, tau_f);
    } else {
      lanes.one.step<PackD>(lanes.theta, {&lanes.in, 1}, h, lanes.z);
    }
    for (int lane = 0; lane < lanes.size; ++lane) {
      double* z = z_.data() + lanes.state[static_cast<std::size_t>(lane)];
      for (std::size_t i = 0; i < lanes.z.size(); ++i) z[i] = lanes.z[i][lane];
    }
  }
  if (foresees_) convert_to_joints();
  remember(foresees_);
}

}  // namespace fricid::sim
