// The reverse of a leap, definitions for the sources that instantiate ArmStepper.
#pragma once

#include "arm_impl.hpp"

namespace fricid {

/// Reverse of a drift; in_ holds its inputs (the new position, v) and z the state before it.
template <class S>
void ArmStepper<S>::drift_pullback(double h, std::span<const S> v, std::span<const S> z,
                                   std::span<S> q_bar, std::span<S> v_bar, std::span<S> z_bar,
                                   std::span<S> theta_bar) {
  std::copy(z_bar.begin(), z_bar.end(), z_next_bar_.begin());
  std::fill(z_bar.begin(), z_bar.end(), S(0));
  std::fill(in_bar_.begin(), in_bar_.end(), friction::Input<S>{S(0), S(0), S(0), S(0)});
  for (std::size_t j = 0; j < in_.size(); ++j) in_[j].v = v[j];
  arm_.friction.model.template step_pullback<S>(theta_, in_, h, z, z_next_bar_, theta_bar, in_bar_,
                                                z_bar);
  for (std::size_t j = 0; j < in_.size(); ++j) {
    q_bar[j] += in_bar_[j].q;
    v_bar[j] += in_bar_[j].v + S(h) * q_bar[j];
  }
}

/// Reverse of  a = M^-1 (tau - h(q, v) - tau_f(in_, z)), with the factor of M in the workspace:
/// lambda = M^-1 a_bar is minus the adjoint of rnea(q, v, a) and of tau_f.
template <class S>
void ArmStepper<S>::acceleration_pullback(std::span<const S> q, std::span<const S> v,
                                          std::span<const S> z, std::span<const S> a,
                                          std::span<const S> a_bar, std::span<S> q_bar,
                                          std::span<S> v_bar, std::span<S> v_friction_bar,
                                          std::span<S> z_bar, std::span<S> pi_bar,
                                          std::span<S> theta_bar) {
  dynamics::solve_with_last_factor<S>(arm_.robot, ws_, a_bar, lambda_);
  for (S& x : lambda_) x = -x;
  dynamics::rnea_pullback<S>(arm_.robot, ws_, pi_, q, v, a, lambda_, q_bar, v_bar, {}, pi_bar);
  std::fill(in_bar_.begin(), in_bar_.end(), friction::Input<S>{S(0), S(0), S(0), S(0)});
  arm_.friction.model.template torque_pullback<S>(theta_, in_, z, lambda_, theta_bar, in_bar_,
                                                  z_bar);
  for (std::size_t j = 0; j < in_.size(); ++j) {
    q_bar[j] += in_bar_[j].q;
    v_friction_bar[j] += in_bar_[j].v;
  }
}

template <class S>
void ArmStepper<S>::leap_pullback(std::span<const S> tau, std::span<const S> temperature, double dt,
                                  std::span<const S> q, std::span<const S> v, std::span<const S> z,
                                  std::span<S> q_bar, std::span<S> v_bar, std::span<S> z_bar,
                                  std::span<S> pi_bar, std::span<S> theta_bar) {
  const Lengths length = lengths(dt);
  if (theta_bar.empty()) theta_bar = theta_unused_;

  // repeat the leap up to its last drift
  std::copy(q.begin(), q.end(), q_mid_.begin());
  std::copy(z.begin(), z.end(), z_mid_.begin());
  set_inputs(tau, temperature, q, v);
  approach(length.before, q_mid_, v, z_mid_);
  acceleration(tau, length.before, q_mid_, v, z_mid_);
  for (std::size_t j = 0; j < a_.size(); ++j) {
    v_new_[j] = v[j] + S(length.leap) * a_[j];
    v_mid_[j] = in_[j].v;
    in_[j].q = q_mid_[j] + S(length.after) * v_new_[j];
  }

  drift_pullback(length.after, v_new_, z_mid_, q_bar, v_bar, z_bar, theta_bar);

  for (std::size_t j = 0; j < a_.size(); ++j) {
    a_bar_[j] = S(length.leap) * v_bar[j];
    in_[j].q = q_mid_[j];
    in_[j].v = v_mid_[j];
    v_friction_bar_[j] = S(0);
  }
  acceleration_pullback(q_mid_, v, z_mid_, a_, a_bar_, q_bar, v_bar, v_friction_bar_, z_bar, pi_bar,
                        theta_bar);
  for (std::size_t j = 0; j < a_.size(); ++j) v_bar[j] += v_friction_bar_[j];
  if (options_.leap == 1) return;

  // the velocity in the middle depends on the acceleration with friction at v
  for (std::size_t j = 0; j < a_.size(); ++j) {
    a_bar_[j] = S(length.before) * v_friction_bar_[j];
    in_[j].v = v[j];
  }
  acceleration_pullback(q_mid_, v, z_mid_, a_lag_, a_bar_, q_bar, v_bar, v_bar, z_bar, pi_bar,
                        theta_bar);
  drift_pullback(length.before, v, z, q_bar, v_bar, z_bar, theta_bar);
}

}  // namespace fricid
