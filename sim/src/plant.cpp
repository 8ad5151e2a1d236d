#include "fricid/sim/plant.hpp"

#include <algorithm>
#include <cmath>

#include "fricid/base/error.hpp"

namespace fricid::sim {
namespace {

// phi(q) of a linear torque.
double shape(const dynamics::LinearTorque& torque, double q) {
  switch (torque.shape) {
    case dynamics::LinearTorque::Shape::kConstant:
      return 1;
    case dynamics::LinearTorque::Shape::kSin:
      return std::sin(torque.k * q);
    case dynamics::LinearTorque::Shape::kCos:
      return std::cos(torque.k * q);
    case dynamics::LinearTorque::Shape::kLinear:
      return q;
  }
  return 0;
}

void copy_row(std::span<const double> values, RowMatrix& matrix, int row) {
  std::copy(values.begin(), values.end(), matrix.row(row).data());
}

}  // namespace

Plant::Plant(const MujocoArm& arm, const dynamics::RobotModel& robot,
             const friction::Friction& friction)
    : arm_(arm), robot_(robot), data_(mj_makeData(&arm.moving())), host_(friction, arm, robot) {
  a_.resize(static_cast<std::size_t>(n()));
  tau_f_.resize(static_cast<std::size_t>(n()));
}

void Plant::set_state(const State& state) {
  mj_resetData(&arm_.moving(), data_.get());
  for (int j = 0; j < n(); ++j) {
    data_->qpos[arm_.qpos(j)] = state.q[static_cast<std::size_t>(j)];
    data_->qvel[arm_.dof(j)] = state.v[static_cast<std::size_t>(j)];
  }
  std::copy(state.z.begin(), state.z.end(), host_.z().begin());
  pushed_ = -1;
}

State Plant::state() const {
  State state;
  for (int j = 0; j < n(); ++j) {
    state.q.push_back(data_->qpos[arm_.qpos(j)]);
    state.v.push_back(data_->qvel[arm_.dof(j)]);
  }
  state.z.assign(host_.z().begin(), host_.z().end());
  return state;
}

void Plant::physics_step(std::span<const double> tau, std::span<const double> temperature) {
  mj_step1(&arm_.moving(), data_.get());
  const std::span<const double> tau_f = host_.torque(*data_, tau, temperature);
  for (int j = 0; j < n(); ++j) {
    const auto i = static_cast<std::size_t>(j);
    data_->qfrc_applied[arm_.dof(j)] = tau[i] - tau_f[i];
  }
  for (std::size_t c = 0; c < robot_.linear_torques.size(); ++c) {
    const dynamics::LinearTorque& torque = robot_.linear_torques[c];
    const double coefficient = robot_.pi[robot_.linear_begin() + static_cast<int>(c)];
    data_->qfrc_applied[arm_.dof(torque.joint)] -=
        coefficient * shape(torque, data_->qpos[arm_.qpos(torque.joint)]);
  }
  mj_step2(&arm_.moving(), data_.get());
  host_.step(*data_, tau, temperature, arm_.step());
}

void Plant::hold(std::span<const double> tau, std::span<const double> temperature, int steps) {
  const std::span<const double> start = host_.torque(*data_, tau, temperature);
  std::copy(start.begin(), start.end(), tau_f_.begin());
  for (int s = 0; s < steps; ++s) {
    physics_step(tau, temperature);
    if (s == 0)
      for (int j = 0; j < n(); ++j) a_[static_cast<std::size_t>(j)] = data_->qacc[arm_.dof(j)];
  }
}

void Plant::push(int joint, const Eigen::Vector3d& force) {
  if (pushed_ >= 0) std::fill_n(data_->xfrc_applied + 6 * pushed_, 6, 0.0);
  pushed_ = arm_.body(joint);
  std::copy(force.begin(), force.end(), data_->xfrc_applied + 6 * pushed_);
}

Eigen::VectorXd Plant::pushed_torque() const {
  Eigen::VectorXd tau = Eigen::VectorXd::Zero(n());
  if (pushed_ < 0) return tau;
  const auto columns = static_cast<Eigen::Index>(arm_.moving().nv);
  RowMatrix jacobian(3, columns);
  mj_jacBodyCom(&arm_.moving(), data_.get(), jacobian.data(), nullptr, pushed_);
  const Eigen::Map<const Eigen::Vector3d> force(data_->xfrc_applied + 6 * pushed_);
  for (int j = 0; j < n(); ++j) tau[j] = jacobian.col(arm_.dof(j)).dot(force);
  return tau;
}

int steps_per_sample(double dt, double physics_step) {
  const double ratio = dt / physics_step;
  const int steps = static_cast<int>(std::lround(ratio));
  if (steps < 1 || std::abs(ratio - steps) > 1e-9 * ratio)
    throw UserError("plant: step_s = {} does not divide the sample period {}", physics_step, dt);
  return steps;
}

void record(const Plant& plant, const State& state, std::span<const double> tau,
            std::span<const double> temperature, int k, Trace& trace) {
  copy_row(state.q, trace.q, k);
  copy_row(state.v, trace.v, k);
  copy_row(state.z, trace.z, k);
  copy_row(plant.a(), trace.a, k);
  copy_row(plant.tau_f(), trace.tau_f, k);
  copy_row(tau, trace.tau, k);
  copy_row(temperature, trace.temperature, k);
}

Trace rollout(Plant& plant, const State& initial, const RowMatrix& tau,
              const RowMatrix& temperature, double dt) {
  const int steps = steps_per_sample(dt, plant.physics_step());
  const auto n = static_cast<std::size_t>(plant.n());
  Trace trace = make_trace(static_cast<int>(tau.rows()), dt, plant.n(), plant.state_size());
  plant.set_state(initial);
  for (int k = 0; k < trace.length(); ++k) {
    const State state = plant.state();
    const std::span<const double> held{tau.row(k).data(), n}, warm{temperature.row(k).data(), n};
    plant.hold(held, warm, steps);
    record(plant, state, held, warm, k, trace);
  }
  return trace;
}

}  // namespace fricid::sim
