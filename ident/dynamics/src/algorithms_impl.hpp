// The algorithms as templates; instantiate.inc instantiates them, tests do so for dual numbers.
#pragma once

#include "chain.hpp"
#include "fricid/dynamics/algorithms.hpp"
#include "linear_torques.hpp"
#include "pullback.hpp"
#include "sweeps.hpp"

namespace fricid::dynamics {

namespace detail {

template <class To>
Link<To> convert(const Link<double>& from) {
  Link<To> to;
  to.revolute = from.revolute;
  to.parent = from.parent;
  to.subtree = from.subtree;
  to.subtree_size = from.subtree_size;
  to.turn = from.turn;
  to.shift = from.shift;
  to.general = convert<To>(from.general);
  to.offset = To(from.offset);
  to.p0 = convert<To>(from.p0);
  to.Q = convert<To>(from.Q);
  to.swaps = from.swaps;
  to.first = from.first;
  to.second = from.second;
  for (size_t k = 0; k < 3; ++k) to.first_zero[k] = To(from.first_zero[k]);
  for (size_t k = 0; k < 6; ++k) to.second_zero[k] = To(from.second_zero[k]);
  return to;
}

template <class S>
struct Kernels {
  using B = Sweeps<S>;

  static void rnea(const RobotModel& model, Workspace<S>& ws, std::span<const S> pi,
                   std::span<const S> q, std::span<const S> v, std::span<const S> a,
                   std::span<S> tau) {
    const size_t n = ws.links_.size();
    const std::span<const S> joints = Motors<S>::joints_of(ws, q, ws.q_);
    B::place(ws, joints);
    B::sweep_out(model, ws, Motors<S>::joints_of(ws, v, ws.v_), Motors<S>::joints_of(ws, a, ws.a_));
    B::own_forces(ws, pi);
    B::template sweep_in<true, false>(ws, tau);
    Motors<S>::to_motors(ws, tau);
    for (size_t i = 0; i < n; ++i) tau[i] = mul_add(pi[10 * n + i], a[i], tau[i]);
    LinearTorques<S>::add(model, ws, pi, joints, tau);
  }

  /// From the mass matrix of the links to that of the motors.
  static void add_armature(Workspace<S>& ws, std::span<const S> pi) {
    const size_t n = ws.links_.size();
    Motors<S>::to_motors(ws);
    for (size_t i = 0; i < n; ++i) ws.M_[i * n + i] += pi[10 * n + i];
  }

  static void crba(Workspace<S>& ws, std::span<const S> pi, std::span<const S> q, std::span<S> M) {
    const size_t n = ws.links_.size();
    B::place(ws, Motors<S>::joints_of(ws, q, ws.q_));
    for (size_t i = 0; i < n; ++i) B::load_body(ws.links_[i], &pi[10 * i], ws.motion_[i].inertia);
    B::template sweep_in<false, true>(ws, {});
    add_armature(ws, pi);
    for (size_t i = 0; i < n; ++i)
      for (size_t k = 0; k <= i; ++k) M[i * n + k] = M[k * n + i] = ws.M_[i * n + k];
  }

  /// Calls f with the number of joints as a compile-time constant for the usual arms, else with 0.
  template <class F>
  static void with_size(size_t n, F&& f) {
    if (n == 6) return f(std::integral_constant<size_t, 6>{});
    if (n == 7) return f(std::integral_constant<size_t, 7>{});
    f(std::integral_constant<size_t, 0>{});
  }

  /// M = L D L' in place; L unit lower.
  static void factorise(Workspace<S>& ws) {
    with_size(ws.links_.size(), [&]<size_t kSize>(std::integral_constant<size_t, kSize>) {
      const size_t n = kSize ? kSize : ws.links_.size();
      S* M = ws.M_.data();
      for (size_t i = 0; i < n; ++i) {
        // row i of L D in place, then of L
        for (size_t k = 0; k < i; ++k) {
          S x = M[i * n + k];
          for (size_t j = 0; j < k; ++j) x = mul_add(-M[i * n + j], M[k * n + j], x);
          M[i * n + k] = x;
        }
        S d = M[i * n + i];
        for (size_t k = 0; k < i; ++k) {
          const S l = M[i * n + k] * ws.inverse_d_[k];
          d = mul_add(-l, M[i * n + k], d);
          M[i * n + k] = l;
        }
        ws.inverse_d_[i] = S(1) / d;
      }
    });
  }

  /// x <- M^-1 x with the factor in ws.
  static void solve(const Workspace<S>& ws, std::span<S> x) {
    with_size(ws.links_.size(), [&]<size_t kSize>(std::integral_constant<size_t, kSize>) {
      const size_t n = kSize ? kSize : ws.links_.size();
      const S* M = ws.M_.data();
      for (size_t i = 0; i < n; ++i) {
        S sum = x[i];
        for (size_t k = 0; k < i; ++k) sum = mul_add(-M[i * n + k], x[k], sum);
        x[i] = sum;
      }
      for (size_t i = n; i-- > 0;) {
        S sum = x[i] * ws.inverse_d_[i];
        for (size_t k = i + 1; k < n; ++k) sum = mul_add(-M[k * n + i], x[k], sum);
        x[i] = sum;
      }
    });
  }

  static void forward_dynamics(const RobotModel& model, Workspace<S>& ws, std::span<const S> pi,
                               std::span<const S> q, std::span<const S> v, std::span<const S> tau,
                               std::span<S> a) {
    const size_t n = ws.links_.size();
    const std::span<const S> joints = Motors<S>::joints_of(ws, q, ws.q_);
    B::place(ws, joints);
    B::sweep_out(model, ws, Motors<S>::joints_of(ws, v, ws.v_), {});
    B::own_forces(ws, pi);
    B::template sweep_in<true, true>(ws, ws.bias_);
    Motors<S>::to_motors(ws, std::span<S>(ws.bias_));
    add_armature(ws, pi);
    LinearTorques<S>::add(model, ws, pi, joints, std::span<S>(ws.bias_));
    for (size_t i = 0; i < n; ++i) a[i] = tau[i] - ws.bias_[i];
    factorise(ws);
    solve(ws, a);
  }
};

}  // namespace detail

template <class S>
Workspace<S>::Workspace(const RobotModel& model)
    : motion_(model.joints.size()),
      adjoint_(model.joints.size()),
      columns_(model.joints.size()),
      M_(model.joints.size() * model.joints.size()),
      inverse_d_(model.joints.size()),
      bias_(model.joints.size()),
      own_frames_(model.joints.size()) {
  for (const auto& link : detail::make_links(model))
    links_.push_back(detail::convert<typename detail::ConstantOf<S>::type>(link));
  for (size_t i = 0; i < links_.size(); ++i) {
    auto& link = links_[i];
    motion_[i].p = detail::convert<S>(link.p0);
    link.subtree = static_cast<int>(subtrees_.size());
    for (size_t k = i; k < links_.size(); ++k) {
      int ancestor = static_cast<int>(k);
      while (ancestor > static_cast<int>(i))
        ancestor = links_[static_cast<size_t>(ancestor)].parent;
      if (ancestor == static_cast<int>(i)) subtrees_.push_back(static_cast<int>(k));
    }
    link.subtree_size = static_cast<int>(subtrees_.size()) - link.subtree;
    if (i + static_cast<size_t>(link.subtree_size) < links_.size()) branched_ = true;
  }
  detail::Motors<S>::set_up(model, *this);
}

template <class S>
void rnea(const RobotModel& model, Workspace<S>& ws, std::span<const S> pi, std::span<const S> q,
          std::span<const S> v, std::span<const S> a, std::span<S> tau) {
  detail::Kernels<S>::rnea(model, ws, pi, q, v, a, tau);
}

template <class S>
void crba(const RobotModel&, Workspace<S>& ws, std::span<const S> pi, std::span<const S> q,
          std::span<S> M) {
  detail::Kernels<S>::crba(ws, pi, q, M);
}

template <class S>
void forward_dynamics(const RobotModel& model, Workspace<S>& ws, std::span<const S> pi,
                      std::span<const S> q, std::span<const S> v, std::span<const S> tau,
                      std::span<S> a) {
  detail::Kernels<S>::forward_dynamics(model, ws, pi, q, v, tau, a);
}

template <class S>
void rnea_pullback(const RobotModel& model, Workspace<S>& ws, std::span<const S> pi,
                   std::span<const S> q, std::span<const S> v, std::span<const S> a,
                   std::span<const S> lambda, std::span<S> q_bar, std::span<S> v_bar,
                   std::span<S> a_bar, std::span<S> pi_bar) {
  detail::Pullback<S>::run(model, ws, pi, q, v, a, lambda, {q_bar, v_bar, a_bar, pi_bar});
}

template <class S>
void solve_with_last_factor(const RobotModel&, const Workspace<S>& ws, std::span<const S> b,
                            std::span<S> x) {
  for (size_t i = 0; i < b.size(); ++i) x[i] = b[i];
  detail::Kernels<S>::solve(ws, x);
}

}  // namespace fricid::dynamics
