#pragma once

#include <array>
#include <span>
#include <string_view>

#include "fricid/base/math.hpp"
#include "fricid/friction/elements.hpp"
#include "fricid/friction/law.hpp"

namespace fricid::friction {

/// Rate-dependent Prandtl-Ishlinskii operator: N springs in parallel whose thresholds grow with
/// speed. With shares a_i = alpha_i / sum alpha and caps c_i(v) = a_i (Fc + Fv |v|), that is
/// thresholds r_i(v) = c_i(v)/k_i = r_i(0) + beta_i |v| of the spring's travel, element i obeys
///
///     stick:  dF_i/dt = k_i v                          while  sgn(v) F_i < c_i
///     slip:   dF_i/dt = k_i v (1 - sgn(v) F_i / c_i)   while  sgn(v) F_i >= c_i
///     tau = sum F_i
///
/// Viscous friction builds up over the travel of presliding and unloads with it: the torque has no
/// jump where v has one, and its noise is not that of v. For held v the solution is closed, with
/// u = sgn(v) F_i:
///
///     u(dt) = min(u + k_i |v| dt, max(u, c_i)) - max(u - c_i, 0) (1 - exp(-k_i |v| dt / c_i))
///
/// v = 0 keeps the state. It differs from the original in one place: where a falling threshold
/// leaves the state outside, the original puts it on the threshold at once, at rest too; here it
/// follows over the travel c_i/k_i. From gms: caps that rise instead of fall, no attraction in
/// time, no viscous torque beside the springs. With Fv = 0 it is maxwell_slip. Friction takes
/// energy in every state: sum F_i v - d/dt sum F_i^2/(2 k_i) = |v| sum u^2/c_i in slip, 0 in stick.
/// Only ratios of alpha count. State: F_i (N), element torques [N m].
class PrandtlIshlinskii {
 public:
  enum Index { kFc, kFv, kCommon };

  static constexpr std::string_view kName = "prandtl_ishlinskii";
  static constexpr std::string_view kEquation =
      "stick dF_i/dt = k_i v until sgn(v) F_i >= c_i, then slip dF_i/dt = k_i v (1 - sgn(v) "
      "F_i/c_i); tau = sum F_i; c_i = alpha_i/sum alpha (Fc + Fv |v|)";
  static constexpr std::string_view kSource =
      "thresholds that grow with speed: Al Janaideh & Krejci, IEEE/ASME Trans. Mechatronics 18(5), "
      "2013; Al Janaideh, Krejci & Monteiro, Applications of Mathematics, 2023";
  static constexpr PlotLook kLook{"#CC3311", 11};
  static constexpr Claims kClaims{};
  static constexpr Reads kReads{};
  static constexpr int kMostElements = kMaxElements;
  static constexpr std::string_view kStateUnit = "N m";

  /// @param elements N, 1 .. kMaxElements
  explicit constexpr PrandtlIshlinskii(int elements) : n_(elements) {}

  constexpr int state_size() const { return n_; }
  constexpr std::span<const ParameterInfo> parameters() const {
    return std::span(kTables[static_cast<std::size_t>(n_)])
        .first(static_cast<std::size_t>(kCommon + 2 * n_));
  }
  /// Indices in theta, after the common ones.
  static constexpr int k(int i) { return kCommon + 2 * i; }
  static constexpr int alpha(int i) { return kCommon + 2 * i + 1; }

  template <class S>
  S torque(const S*, const Input<S>&, const S* F) const {
    S tau = S(0);
    for (int i = 0; i < n_; ++i) tau += F[i];
    return tau;
  }

  template <class S>
  void step(const S* theta, const Input<S>& in, double dt, S* F) const {
    const Held<S> h = held(theta, in.v, dt);
    for (int i = 0; i < n_; ++i) {
      const S c = theta[alpha(i)] * h.cap_per_alpha, rise = theta[k(i)] * h.travel;
      const S u = h.direction * F[i];
      const S next = min(u + rise, max(u, c)) + max(u - c, S(0)) * expm1(-rise / c);
      F[i] = select(h.stuck, F[i], h.direction * next);
    }
  }

  template <class S>
  void torque_pullback(const S*, const Input<S>&, const S*, const S& tau_bar, S*, Input<S>&,
                       S* F_bar) const {
    for (int i = 0; i < n_; ++i) F_bar[i] += tau_bar;
  }

  template <class S>
  void step_pullback(const S* theta, const Input<S>& in, double dt, const S* F, const S* F_next_bar,
                     S* theta_bar, Input<S>& in_bar, S* F_bar) const {
    const Held<S> h = held(theta, in.v, dt);
    S cap_per_alpha_bar = S(0), travel_bar = S(0);
    for (int i = 0; i < n_; ++i) {
      const S c = theta[alpha(i)] * h.cap_per_alpha, rise = theta[k(i)] * h.travel;
      const S u = h.direction * F[i];
      const auto slips = u >= c;
      const auto sticks = u + rise < c;
      const S next_bar = select(h.stuck, S(0), h.direction * F_next_bar[i]);
      const S slip_bar = select(slips, next_bar, S(0));
      const S stick_bar = select(sticks, next_bar, S(0));
      const S x = rise / c;
      const S left = S(1) + expm1(-x);  // e^-x

      // slip: next = c + (u - c) e^-x;  stick: u + rise;  on the way from one to the other: c
      const S x_bar = -slip_bar * (u - c) * left;
      const S c_bar = next_bar - stick_bar - slip_bar * left - x_bar * x / c;
      const S rise_bar = stick_bar + x_bar / c;
      theta_bar[k(i)] += rise_bar * h.travel;
      travel_bar += rise_bar * theta[k(i)];
      theta_bar[alpha(i)] += c_bar * h.cap_per_alpha;
      cap_per_alpha_bar += c_bar * theta[alpha(i)];
      F_bar[i] += select(h.stuck, F_next_bar[i], h.direction * (stick_bar + slip_bar * left));
    }
    // travel = |v| dt,  cap_per_alpha = (Fc + Fv |v|) / sum alpha
    const S sum_bar = -cap_per_alpha_bar * h.cap_per_alpha / h.alpha_sum;
    for (int i = 0; i < n_; ++i) theta_bar[alpha(i)] += sum_bar;
    const S level_bar = cap_per_alpha_bar / h.alpha_sum;
    theta_bar[kFc] += level_bar;
    theta_bar[kFv] += level_bar * abs(in.v);
    in_bar.v += (travel_bar * S(dt) + level_bar * theta[kFv]) * h.direction;
  }

  /// v = 0 returns 0.
  template <class S>
  S steady_torque(const S* theta, const Input<S>& in) const {
    return level(theta, in.v) * sign(in.v);
  }

  void state_bound(const double* theta, double fastest, double* bound) const {
    double sum = 0;
    for (int i = 0; i < n_; ++i) sum += theta[alpha(i)];
    for (int i = 0; i < n_; ++i) bound[i] = theta[alpha(i)] / sum * level(theta, fastest);
  }

 private:
  template <class S>
  static S level(const S* theta, const S& v) {
    return theta[kFc] + theta[kFv] * abs(v);
  }

  // what all elements share during a step
  template <class S>
  struct Held {
    S alpha_sum, cap_per_alpha, travel, direction;
    decltype(S(0) == S(0)) stuck;
  };

  template <class S>
  Held<S> held(const S* theta, const S& v, double dt) const {
    S alpha_sum = theta[alpha(0)];
    for (int i = 1; i < n_; ++i) alpha_sum += theta[alpha(i)];
    return {alpha_sum, level(theta, v) / alpha_sum, abs(v) * S(dt), select(v < S(0), S(-1), S(1)),
            v == S(0)};
  }

  // typical: equal shares, presliding lengths spread from 0.2 to 4 mrad
  static constexpr double kTorqueTypical = 5;
  static constexpr auto kTables = element_tables(
      std::array<ParameterInfo, kCommon>{{
          {"Fc", "N m", Role::kCoulomb, 1e-6, 1e6, kTorqueTypical, Scale::kLog, "Coulomb friction"},
          {"Fv", "N m s/rad", Role::kViscous, 0, 1e6, 2.5, Scale::kLinear,
           "growth of the level with speed"},
      }},
      [](int i, int n) {
        return std::array<ParameterInfo, 2>{{
            {numbered<"k">(i), "N m/rad", Role::kStiffness, 1e-4, 1e9,
             kTorqueTypical / n / typical_length(i, n), Scale::kLog, "stiffness of the element",
             i + 1},
            {numbered<"alpha">(i), "1", Role::kShare, 1e-6, 1e3, 1.0 / n, Scale::kLog,
             "share of the element, relative to the sum of all", i + 1},
        }};
      });

  int n_;
};

}  // namespace fricid::friction
