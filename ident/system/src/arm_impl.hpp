// Definitions of ArmStepper's templates, for the sources that instantiate them: double, PackD and
// PackF in the library, dual numbers in the tests.
#pragma once

#include <algorithm>
#include <cassert>

#include "fricid/base/error.hpp"
#include "fricid/system/arm.hpp"

namespace fricid {
namespace detail {

template <class S, class Range>
std::vector<S> broadcast(const Range& values) {
  std::vector<S> lanes;
  lanes.reserve(static_cast<std::size_t>(values.size()));
  for (const double value : values) lanes.push_back(S(value));
  return lanes;
}

}  // namespace detail

template <class S>
ArmStepper<S>::ArmStepper(const Arm& arm, StepOptions options)
    : arm_(arm),
      options_(options),
      ws_(arm.robot),
      pi_(detail::broadcast<S>(arm.robot.pi)),
      theta_(detail::broadcast<S>(arm.friction.theta)) {
  const int n = arm.robot.n();
  if (arm.friction.model.joint_count() != n)
    throw UserError("friction has {} joints, the robot has {}", arm.friction.model.joint_count(),
                    n);
  if (options.substeps < 1)
    throw UserError("substeps: found {}, allowed 1 or more", options.substeps);
  if (options.leap < 1 || options.substeps % options.leap != 0)
    throw UserError("leap: found {}, allowed a divisor of substeps {}", options.leap,
                    options.substeps);
  const auto size = static_cast<std::size_t>(n);
  tau_f_.resize(size);
  net_.resize(size);
  a_.resize(size);
  correction_.resize(size);
  in_.resize(size);

  const auto nz = static_cast<std::size_t>(arm.friction.model.state_size());
  for (auto* x : {&q_mid_, &v_mid_, &v_new_, &a_lag_, &a_bar_, &lambda_, &v_friction_bar_})
    x->resize(size);
  for (auto* x : {&z_mid_, &z_next_bar_}) x->resize(nz);
  theta_unused_.resize(theta_.size());
  in_bar_.resize(size);
}

template <class S>
void ArmStepper<S>::set_parameters(std::span<const S> pi, std::span<const S> theta) {
  assert(pi.size() == pi_.size() && theta.size() == theta_.size());
  std::copy(pi.begin(), pi.end(), pi_.begin());
  std::copy(theta.begin(), theta.end(), theta_.begin());
}

template <class S>
void ArmStepper<S>::set_inputs(std::span<const S> tau, std::span<const S> temperature,
                               std::span<const S> q, std::span<const S> v) {
  for (std::size_t j = 0; j < in_.size(); ++j) in_[j] = {q[j], v[j], tau[j], temperature[j]};
}

template <class S>
void ArmStepper<S>::friction_torque(std::span<const S> tau, std::span<const S> temperature,
                                    std::span<const S> q, std::span<const S> v,
                                    std::span<const S> z, std::span<S> tau_f) {
  set_inputs(tau, temperature, q, v);
  arm_.friction.model.template torque<S>(theta_, in_, z, tau_f);
}

/// Moves q by h at constant velocity; leaves in_ at the new position.
template <class S>
void ArmStepper<S>::drift_position(double h, std::span<S> q, std::span<const S> v) {
  const S lane_h(h);
  for (std::size_t j = 0; j < in_.size(); ++j) {
    q[j] += lane_h * v[j];
    in_[j].q = q[j];
    in_[j].v = v[j];
  }
}

/// The first drift of a leap: moves q and z, and sets in_ and tau_f_ for the kick.
template <class S>
void ArmStepper<S>::approach(double before, std::span<S> q, std::span<const S> v, std::span<S> z) {
  const friction::RobotFriction& friction = arm_.friction.model;
  if (options_.leap == 1) return friction.template torque<S>(theta_, in_, z, tau_f_);
  drift_position(before, q, v);
  friction.template step_torque<S>(theta_, in_, before, z, tau_f_);
}

/// a_ at (q, v, z) = in_ under friction tau_f_, friction at the velocity `ahead` [s] later; then
/// a_lag_ is the acceleration with friction at v, and in_ holds the later velocity.
template <class S>
void ArmStepper<S>::acceleration(std::span<const S> tau, double ahead, std::span<const S> q,
                                 std::span<const S> v, std::span<const S> z) {
  for (std::size_t j = 0; j < net_.size(); ++j) net_[j] = tau[j] - tau_f_[j];
  dynamics::forward_dynamics<S>(arm_.robot, ws_, pi_, q, v, net_, a_);
  if (ahead == 0) return;

  for (std::size_t j = 0; j < in_.size(); ++j) {
    a_lag_[j] = a_[j];
    in_[j].v = v[j] + S(ahead) * a_[j];
  }
  arm_.friction.model.template torque<S>(theta_, in_, z, net_);
  for (std::size_t j = 0; j < net_.size(); ++j) net_[j] = tau_f_[j] - net_[j];
  dynamics::solve_with_last_factor<S>(arm_.robot, ws_, net_, correction_);
  for (std::size_t j = 0; j < a_.size(); ++j) a_[j] += correction_[j];
}

template <class S>
auto ArmStepper<S>::lengths(double dt) const -> Lengths {
  const double h = dt / options_.substeps, H = h * options_.leap;
  return {(H - h) / 2, H - (H - h) / 2, H};
}

template <class S>
void ArmStepper<S>::leap(std::span<const S> tau, std::span<const S> temperature, double dt,
                         std::span<S> q, std::span<S> v, std::span<S> z) {
  const Lengths length = lengths(dt);
  set_inputs(tau, temperature, q, v);
  approach(length.before, q, v, z);
  acceleration(tau, length.before, q, v, z);
  for (std::size_t j = 0; j < a_.size(); ++j) v[j] += S(length.leap) * a_[j];
  drift_position(length.after, q, v);
  arm_.friction.model.template step<S>(theta_, in_, length.after, z);
}

template <class S>
void ArmStepper<S>::step(std::span<const S> tau, std::span<const S> temperature, double dt,
                         std::span<S> q, std::span<S> v, std::span<S> z) {
  for (int k = 0; k < leaps(); ++k) leap(tau, temperature, dt, q, v, z);
}

}  // namespace fricid
