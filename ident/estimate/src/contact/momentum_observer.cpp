#include "fricid/estimate/contact/momentum_observer.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "fricid/base/error.hpp"

namespace fricid::estimate {
namespace {

std::span<const double> parameters(const dynamics::RobotModel& robot) {
  return {robot.pi.data(), static_cast<std::size_t>(robot.pi.size())};
}

dynamics::RobotModel without_weight(dynamics::RobotModel robot) {
  robot.gravity.setZero();
  robot.pi.tail(robot.pi.size() - robot.linear_begin()).setZero();
  return robot;
}

}  // namespace

MomentumObserver::MomentumObserver(Arm arm, double dt, double bandwidth_hz,
                                   std::span<const double> z0)
    : arm_(std::move(arm)),
      weightless_(without_weight(arm_.robot)),
      ws_(arm_.robot),
      weightless_ws_(weightless_),
      follower_(std::in_place, arm_.friction, dt, z0),
      dt_(dt),
      share_(-std::expm1(-2 * std::numbers::pi * bandwidth_hz * dt)) {
  if (arm_.friction.model.joint_count() != arm_.robot.n())
    throw UserError("momentum observer: friction of {} joints, robot of {}",
                    arm_.friction.model.joint_count(), arm_.robot.n());
  const auto n = static_cast<std::size_t>(arm_.robot.n());
  for (std::vector<double>* x :
       {&r_, &q_, &v_, &p_, &tau_, &tau_f_, &v_now_, &p_now_, &middle_, &mean_v_, &mean_tau_,
        &seen_, &seen_before_, &seen_v_, &gravity_, &gradient_, &zero_})
    x->assign(n, 0.0);
  M_.assign(n * n, 0.0);
}

void MomentumObserver::momentum(std::span<const double> q, std::span<const double> v,
                                std::span<double> p) {
  const std::size_t n = q.size();
  dynamics::crba<double>(arm_.robot, ws_, parameters(arm_.robot), q, M_);
  for (std::size_t j = 0; j < n; ++j) {
    p[j] = 0;
    for (std::size_t i = 0; i < n; ++i) p[j] += M_[j * n + i] * v[i];
  }
}

void MomentumObserver::kinetic_gradient(std::span<const double> q, std::span<const double> v) {
  // half of v' d(M(q) v)/dq
  std::ranges::fill(gradient_, 0.0);
  dynamics::rnea_pullback<double>(weightless_, weightless_ws_, parameters(weightless_), q, zero_, v,
                                  v, gradient_, {}, {}, {});
  for (double& value : gradient_) value /= 2;
}

// Velocities and momentum of the sample that ended; whether there was one before.
bool MomentumObserver::measure(std::span<const double> tau, std::span<const double> q) {
  if (samples_ == 0) return false;
  for (std::size_t j = 0; j < q.size(); ++j) {
    v_now_[j] = (q[j] - q_[j]) / dt_;
    middle_[j] = (q[j] + q_[j]) / 2;
  }
  momentum(middle_, v_now_, p_now_);
  for (std::size_t j = 0; j < q.size(); ++j) {
    mean_v_[j] = (v_[j] + v_now_[j]) / 2;
    mean_tau_[j] = (tau_[j] + tau[j]) / 2;
  }
  return samples_ > 1;
}

// The low-pass, with the friction tau_f_ between the two samples.
std::span<const double> MomentumObserver::advance(std::span<const double> tau,
                                                  std::span<const double> q,
                                                  std::span<const double> seen) {
  if (samples_ > 1) {
    dynamics::rnea<double>(arm_.robot, ws_, parameters(arm_.robot), q_, zero_, zero_, gravity_);
    kinetic_gradient(q_, mean_v_);
    for (std::size_t j = 0; j < q.size(); ++j) {
      const double known = mean_tau_[j] - tau_f_[j] + gradient_[j] - gravity_[j];
      r_[j] += share_ * ((p_now_[j] - p_[j]) / dt_ - known - r_[j]);
    }
  }
  std::ranges::copy(q, q_.begin());
  std::ranges::copy(tau, tau_.begin());
  std::swap(seen_before_, seen_);
  std::ranges::copy(seen, seen_.begin());
  std::swap(v_, v_now_);
  std::swap(p_, p_now_);
  ++samples_;
  return r_;
}

void MomentumObserver::restart() {
  samples_ = 0;
  std::ranges::fill(r_, 0.0);
  const std::vector<double> z(follower_->z().begin(), follower_->z().end());
  follower_.emplace(arm_.friction, dt_, z);
}

// The friction torque at the last sample.
std::span<const double> MomentumObserver::follow(std::span<const double> temperature,
                                                 std::span<const double> seen) {
  for (std::size_t j = 0; j < seen.size(); ++j)
    seen_v_[j] = (seen[j] - seen_before_[j]) / (2 * dt_);
  return follower_->follow(seen_, seen_v_, mean_tau_, temperature);
}

std::span<const double> MomentumObserver::step(std::span<const double> tau,
                                               std::span<const double> q,
                                               std::span<const double> temperature,
                                               std::span<const double> seen) {
  if (seen.empty()) seen = q;
  if (measure(tau, q)) std::ranges::copy(follow(temperature, seen), tau_f_.begin());
  return advance(tau, q, seen);
}

std::span<const double> MomentumObserver::step_with(std::span<const double> tau,
                                                    std::span<const double> q,
                                                    std::span<const double> temperature,
                                                    std::span<const double> tau_f,
                                                    std::span<const double> seen) {
  if (seen.empty()) seen = q;
  if (measure(tau, q)) follow(temperature, seen);
  std::ranges::copy(tau_f, tau_f_.begin());
  return advance(tau, q, seen);
}

}  // namespace fricid::estimate
