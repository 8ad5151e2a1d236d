// Between joints and coupled motors: q = A m, tau_m = A' tau_q. Nothing where A is not stored.
#pragma once

#include <algorithm>
#include <span>
#include <vector>

#include "fricid/base/math.hpp"
#include "fricid/dynamics/workspace.hpp"

namespace fricid::dynamics::detail {

template <class S>
struct Motors {
  /// Makes room in a workspace.
  static void set_up(const RobotModel& model, Workspace<S>& ws) {
    if (!model.coupled()) return;
    const auto n = model.joints.size();
    const Eigen::MatrixXd A = model.joints_of_motors();
    for (Eigen::Index i = 0; i < A.rows(); ++i)
      for (Eigen::Index k = 0; k < A.cols(); ++k)
        ws.A_.push_back(S(static_cast<typename ConstantOf<S>::type>(A(i, k))));
    for (auto* x : {&ws.q_, &ws.v_, &ws.a_, &ws.tau_, &ws.q_bar_, &ws.v_bar_, &ws.a_bar_})
      x->resize(n);
    ws.MA_.resize(n * n);
  }

  /// A m, in `room`; m itself without couplings, and where it is empty.
  static std::span<const S> joints_of(const Workspace<S>& ws, std::span<const S> m,
                                      std::vector<S>& room) {
    if (ws.A_.empty() || m.empty()) return m;
    const size_t n = m.size();
    for (size_t i = 0; i < n; ++i) {
      S sum(0);
      for (size_t k = 0; k < n; ++k) sum += ws.A_[i * n + k] * m[k];
      room[i] = sum;
    }
    return room;
  }

  /// tau <- A' tau.
  static void to_motors(Workspace<S>& ws, std::span<S> tau) {
    if (ws.A_.empty() || tau.empty()) return;
    std::copy(tau.begin(), tau.end(), ws.tau_.begin());
    std::fill(tau.begin(), tau.end(), S(0));
    for (size_t i = 0; i < tau.size(); ++i) add(ws, i, ws.tau_[i], tau);
  }

  /// Adds a torque at joint i to those of the motors.
  static void add(const Workspace<S>& ws, size_t i, const S& torque, std::span<S> tau) {
    if (ws.A_.empty()) {
      tau[i] += torque;
      return;
    }
    const size_t n = tau.size();
    for (size_t k = 0; k < n; ++k) tau[k] += ws.A_[i * n + k] * torque;
  }

  /// The lower triangle of A' M A in place of that of M.
  static void to_motors(Workspace<S>& ws) {
    if (ws.A_.empty()) return;
    const size_t n = ws.links_.size();
    const auto M = [&](size_t i, size_t k) { return ws.M_[i > k ? i * n + k : k * n + i]; };
    for (size_t i = 0; i < n; ++i)
      for (size_t k = 0; k < n; ++k) {
        S sum(0);
        for (size_t j = 0; j < n; ++j) sum += M(i, j) * ws.A_[j * n + k];
        ws.MA_[i * n + k] = sum;
      }
    for (size_t i = 0; i < n; ++i)
      for (size_t k = 0; k <= i; ++k) {
        S sum(0);
        for (size_t j = 0; j < n; ++j) sum += ws.A_[j * n + i] * ws.MA_[j * n + k];
        ws.M_[i * n + k] = sum;
      }
  }
};

}  // namespace fricid::dynamics::detail
