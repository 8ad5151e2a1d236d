#pragma once

#include <algorithm>
#include <array>
#include <span>
#include <string_view>

#include "fricid/base/math.hpp"
#include "fricid/friction/elements.hpp"
#include "fricid/friction/law.hpp"
#include "fricid/friction/stribeck_curve.hpp"

namespace fricid::friction {

/// Generalised Maxwell slip: N springs in parallel that stick, then slip towards their share of the
/// Stribeck curve. With s(v) = Fc + (Fs - Fc) exp(-(v/vs)^2), shares a_i = alpha_i / sum alpha and
/// caps c_i = a_i s(v), element i obeys
///
///     stick:  dF_i/dt = k_i v                                 while  sgn(v) F_i < c_i
///     slip:   dF_i/dt = sgn(v) C (a_i - sgn(v) F_i / s(v))    while  sgn(v) F_i >= c_i
///     tau = sum F_i + Fv v
///
/// For held v the solution is closed, the switch inside a step included: with u = sgn(v) F_i,
///
///     u(dt) = min(u + k_i |v| dt, max(u, c_i)) - max(u - c_i, 0) (1 - exp(-C dt / s(v)))
///
/// The state decides between stick and slip, there is no flag; v = 0 keeps it. The test is
/// sgn(v) F >= c, never |F| >= c, which would make every element slip at a reversal as soon as c
/// depends on speed, load or direction. It differs from the original with a flag in one place:
/// while sgn(v) F < c after slipping (v falls, so s(v) grows), F follows the cap through its spring
/// instead of the attraction C. Only ratios of alpha count. State: F_i (N), element torques [N m].
class Gms {
 public:
  enum Index { kFc, kFs, kVs, kC, kFv, kCommon };

  static constexpr std::string_view kName = "gms";
  static constexpr std::string_view kEquation =
      "stick dF_i/dt = k_i v until sgn(v) F_i >= a_i s(v), then slip dF_i/dt = sgn(v) C (a_i - "
      "sgn(v) F_i/s(v)); tau = sum F_i + Fv v; a_i = alpha_i/sum alpha; s(v) = Fc + (Fs - Fc) "
      "exp(-(v/vs)^2)";
  static constexpr std::string_view kSource =
      "Al-Bender, Lampaert & Swevers, IEEE TAC 50(11), 2005";
  static constexpr PlotLook kLook{"#D55E00", 7};
  static constexpr Claims kClaims{};
  static constexpr Reads kReads{};
  static constexpr int kMostElements = kMaxElements;
  static constexpr std::string_view kStateUnit = "N m";

  /// @param elements N, 1 .. kMaxElements
  explicit constexpr Gms(int elements) : n_(elements) {}

  constexpr int state_size() const { return n_; }
  constexpr std::span<const ParameterInfo> parameters() const {
    return std::span(kTables[static_cast<std::size_t>(n_)])
        .first(static_cast<std::size_t>(kCommon + 2 * n_));
  }
  /// Indices in theta, after the common ones.
  static constexpr int k(int i) { return kCommon + 2 * i; }
  static constexpr int alpha(int i) { return kCommon + 2 * i + 1; }

  template <class S>
  S torque(const S* theta, const Input<S>& in, const S* F) const {
    S tau = theta[kFv] * in.v;
    for (int i = 0; i < n_; ++i) tau += F[i];
    return tau;
  }

  template <class S>
  void step(const S* theta, const Input<S>& in, double dt, S* F) const {
    const Held<S> h = held(theta, in.v, dt);
    for (int i = 0; i < n_; ++i) {
      const S c = theta[alpha(i)] * h.cap_per_alpha;
      const S u = h.direction * F[i];
      const S over = max(u - c, S(0));
      F[i] = h.direction * fma(-over, h.fall, min(fma(theta[k(i)], h.travel, u), max(u, c)));
    }
  }

  template <class S>
  void torque_pullback(const S* theta, const Input<S>& in, const S*, const S& tau_bar, S* theta_bar,
                       Input<S>& in_bar, S* F_bar) const {
    theta_bar[kFv] += tau_bar * in.v;
    in_bar.v += tau_bar * theta[kFv];
    for (int i = 0; i < n_; ++i) F_bar[i] += tau_bar;
  }

  template <class S>
  void step_pullback(const S* theta, const Input<S>& in, double dt, const S* F, const S* F_next_bar,
                     S* theta_bar, Input<S>& in_bar, S* F_bar) const {
    const Held<S> h = held(theta, in.v, dt);
    S fall_bar = S(0), cap_per_alpha_bar = S(0), travel_bar = S(0);
    for (int i = 0; i < n_; ++i) {
      const S c = theta[alpha(i)] * h.cap_per_alpha;
      const S u = h.direction * F[i];
      const auto slips = u >= c;
      const auto sticks = u + theta[k(i)] * h.travel < c;
      const S next_bar = select(h.stuck, S(0), h.direction * F_next_bar[i]);
      const S slip_bar = select(slips, next_bar, S(0));
      const S stick_bar = select(sticks, next_bar, S(0));
      const S c_bar = next_bar - stick_bar - slip_bar * (S(1) - h.fall);

      fall_bar -= slip_bar * (u - c);
      theta_bar[k(i)] += stick_bar * h.travel;
      travel_bar += stick_bar * theta[k(i)];
      theta_bar[alpha(i)] += c_bar * h.cap_per_alpha;
      cap_per_alpha_bar += c_bar * theta[alpha(i)];
      F_bar[i] +=
          select(h.stuck, F_next_bar[i], h.direction * (stick_bar + slip_bar * (S(1) - h.fall)));
    }
    in_bar.v += travel_bar * S(dt) * h.direction;

    // cap_per_alpha = s / sum alpha,  fall = 1 - exp(-C dt / s)
    const S sum_bar = -cap_per_alpha_bar * h.cap_per_alpha / h.alpha_sum;
    for (int i = 0; i < n_; ++i) theta_bar[alpha(i)] += sum_bar;
    const S exponent_bar = -fall_bar * (S(1) - h.fall);
    theta_bar[kC] -= exponent_bar * S(dt) / h.s.value;
    const S s_bar = cap_per_alpha_bar / h.alpha_sum +
                    exponent_bar * theta[kC] * S(dt) / (h.s.value * h.s.value);
    stribeck_curve_pullback(theta[kFc], theta[kFs], theta[kVs], in.v, h.s, s_bar, S(0),
                            theta_bar[kFc], theta_bar[kFs], theta_bar[kVs], in_bar.v);
  }

  /// dF_i/dtheta has six entries per element: k_i, alpha_i with sum alpha held, C, Fc, Fs, vs. That
  /// by sum alpha follows, since only ratios count.
  constexpr int tangent_size() const { return kTangents * n_; }

  template <class S>
  void step_tangent(const S* theta, const Input<S>& in, double dt, const S* F, S* T) const {
    const Held<S> h = held(theta, in.v, dt);
    const S by_Fc = S(1) - h.s.e, by_Fs = h.s.e;
    const S r = in.v / theta[kVs];
    const S by_vs = (theta[kFs] - theta[kFc]) * h.s.e * S(2) * r * r / theta[kVs];
    const S fall_by_C = (S(1) - h.fall) * S(dt) / h.s.value;
    for (int i = 0; i < n_; ++i, T += kTangents) {
      const Slopes<S> by = slopes(theta, h, dt, i, F[i]);
      T[0] = by.F * T[0] + by.k;
      T[1] = by.F * T[1] + by.cap * h.cap_per_alpha;
      T[2] = by.F * T[2] + by.fall * fall_by_C;
      T[3] = by.F * T[3] + by.s * by_Fc;
      T[4] = by.F * T[4] + by.s * by_Fs;
      T[5] = by.F * T[5] + by.s * by_vs;
    }
  }

  template <class S>
  void step_slopes(const S* theta, const Input<S>& in, double dt, const S* F, S* by_F,
                   S* by_v) const {
    const Held<S> h = held(theta, in.v, dt);
    const S s_by_v = (theta[kFc] - theta[kFs]) * h.s.e * S(2) * in.v / (theta[kVs] * theta[kVs]);
    for (int i = 0; i < n_; ++i) {
      const Slopes<S> by = slopes(theta, h, dt, i, F[i]);
      by_F[i] = by.F;
      by_v[i] = by.travel * S(dt) + by.s * s_by_v;
    }
  }

  template <class S>
  void add_tangent(const S* theta, const S* F_bar, const S* T, S* theta_bar) const {
    S alpha_sum = S(0), moved = S(0);
    for (int i = 0; i < n_; ++i, T += kTangents) {
      const S own = F_bar[i] * T[1];
      theta_bar[k(i)] += F_bar[i] * T[0];
      theta_bar[alpha(i)] += own;
      alpha_sum += theta[alpha(i)];
      moved += theta[alpha(i)] * own;
      theta_bar[kC] += F_bar[i] * T[2];
      theta_bar[kFc] += F_bar[i] * T[3];
      theta_bar[kFs] += F_bar[i] * T[4];
      theta_bar[kVs] += F_bar[i] * T[5];
    }
    const S by_sum = moved / alpha_sum;
    for (int i = 0; i < n_; ++i) theta_bar[alpha(i)] -= by_sum;
  }

  /// v = 0 returns 0.
  template <class S>
  S steady_torque(const S* theta, const Input<S>& in) const {
    return stribeck_curve(theta[kFc], theta[kFs], theta[kVs], in.v).value * sign(in.v) +
           theta[kFv] * in.v;
  }

  void state_bound(const double* theta, double, double* bound) const {
    double sum = 0;
    for (int i = 0; i < n_; ++i) sum += theta[alpha(i)];
    for (int i = 0; i < n_; ++i)
      bound[i] = theta[alpha(i)] / sum * std::max(theta[kFc], theta[kFs]);
  }

 private:
  static constexpr int kTangents = 6;  // per element

  // what all elements share during a step
  template <class S>
  struct Held {
    StribeckCurve<S> s;
    S alpha_sum, cap_per_alpha, travel, direction, fall;
    decltype(S(0) == S(0)) stuck;
  };

  // F_i' to first order, alpha_sum held
  template <class S>
  struct Slopes {
    S F, k, cap, fall, s;
    S travel;  // v dt
  };

  template <class S>
  Slopes<S> slopes(const S* theta, const Held<S>& h, double dt, int i, const S& F) const {
    const S c = theta[alpha(i)] * h.cap_per_alpha;
    const S u = h.direction * F;
    const auto slips = u >= c;
    const auto keeps = h.stuck | (u + theta[k(i)] * h.travel < c);
    const auto moves = keeps & !h.stuck;
    const S by_cap = select(keeps, S(0), select(slips, h.direction * h.fall, h.direction));
    const S by_fall = select(keeps | !slips, S(0), h.direction * (c - u));
    const S fall_by_s = -(S(1) - h.fall) * S(dt) * theta[kC] / (h.s.value * h.s.value);
    return {select(keeps, S(1), select(slips, S(1) - h.fall, S(0))),
            select(moves, h.direction * h.travel, S(0)),
            by_cap,
            by_fall,
            by_cap * theta[alpha(i)] / h.alpha_sum + by_fall * fall_by_s,
            select(moves, theta[k(i)], S(0))};
  }

  template <class S>
  Held<S> held(const S* theta, const S& v, double dt) const {
    const StribeckCurve<S> s = stribeck_curve(theta[kFc], theta[kFs], theta[kVs], v);
    S alpha_sum = theta[alpha(0)];
    for (int i = 1; i < n_; ++i) alpha_sum += theta[alpha(i)];
    const auto stuck = v == S(0);
    return {s,
            alpha_sum,
            s.value / alpha_sum,
            abs(v) * S(dt),
            select(v < S(0), S(-1), S(1)),
            select(stuck, S(0), S(1) - decay(theta[kC] * S(dt) / s.value)),
            stuck};
  }

  // typical: equal shares, presliding lengths spread from 0.2 to 4 mrad
  static constexpr double kFsTypical = 6;
  static constexpr auto kTables = element_tables(
      std::array<ParameterInfo, kCommon>{{
          {"Fc", "N m", Role::kCoulomb, 1e-6, 1e6, 5, Scale::kLog, "Coulomb friction"},
          {"Fs", "N m", Role::kStatic, 1e-6, 1e6, kFsTypical, Scale::kLog, "static friction"},
          {"vs", "rad/s", Role::kStribeckVelocity, 1e-4, 10, 0.05, Scale::kLog,
           "Stribeck velocity"},
          {"C", "N m/s", Role::kAttraction, 1e-2, 1e8, 150, Scale::kLog,
           "attraction to the Stribeck curve"},
          {"Fv", "N m s/rad", Role::kViscous, 0, 1e6, 2.5, Scale::kLinear, "viscous coefficient"},
      }},
      [](int i, int n) {
        return std::array<ParameterInfo, 2>{{
            {numbered<"k">(i), "N m/rad", Role::kStiffness, 1e-4, 1e9,
             kFsTypical / n / typical_length(i, n), Scale::kLog, "stiffness of the element", i + 1},
            {numbered<"alpha">(i), "1", Role::kShare, 1e-6, 1e3, 1.0 / n, Scale::kLog,
             "share of the element, relative to the sum of all", i + 1},
        }};
      });

  int n_;
};

}  // namespace fricid::friction
