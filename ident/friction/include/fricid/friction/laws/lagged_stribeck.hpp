#pragma once

#include <array>
#include <span>
#include <string_view>

#include "fricid/base/math.hpp"
#include "fricid/friction/law.hpp"
#include "fricid/friction/stribeck_curve.hpp"

namespace fricid::friction {

/// Stribeck friction of a speed s that lags behind that of the joint (frictional lag):
///
///     ds/dt = (v - s)/T                  s' = v + (s - v) exp(-dt/T), exact for held v
///     tau   = (Fc + (Fs - Fc) exp(-(s/vs)^2)) tanh(s/v0) + Fv s
///
/// At a reversal friction keeps its direction for about T, however slow the motion. In exactly v =
/// 0 the state is kept, as that of every law. Friction takes energy: tau(s) v = tau(s) s + T d/dt
/// int tau ds. State: s (1) [rad/s].
class LaggedStribeck {
 public:
  enum Index { kFc, kFs, kVs, kFv, kV0, kLag, kSize };

  static constexpr std::string_view kName = "lagged_stribeck";
  static constexpr std::string_view kEquation =
      "ds/dt = (v - s)/T; tau = (Fc + (Fs - Fc) exp(-(s/vs)^2)) tanh(s/v0) + Fv s";
  static constexpr std::string_view kSource =
      "frictional lag: Hess & Soom, J. Tribology 112, 1990; Armstrong-Helouvry, Dupont & Canudas "
      "de "
      "Wit, Automatica 30, 1994";
  static constexpr PlotLook kLook{"#B15928", 15};
  static constexpr Claims kClaims{};
  static constexpr Reads kReads{};
  static constexpr int kMostElements = 0;
  static constexpr std::string_view kStateUnit = "rad/s";

  static constexpr int state_size() { return 1; }
  static constexpr std::span<const ParameterInfo> parameters() { return kParameters; }

  template <class S>
  S torque(const S* theta, const Input<S>&, const S* s) const {
    return torque_of(theta, s[0]);
  }

  template <class S>
  void step(const S* theta, const Input<S>& in, double dt, S* s) const {
    // s + (v - s) (1 - e^-x): dt = 0 keeps the state to the last bit
    const S next = s[0] + (s[0] - in.v) * expm1(-(S(dt) / theta[kLag]));
    s[0] = select(in.v == S(0), s[0], next);
  }

  template <class S>
  void torque_pullback(const S* theta, const Input<S>&, const S* s, const S& tau_bar, S* theta_bar,
                       Input<S>&, S* s_bar) const {
    const StribeckCurve<S> level = curve(theta, s[0]);
    const S r = s[0] / theta[kV0], t = tanh(r);
    const S r_bar = tau_bar * level.value * (S(1) - t * t);
    theta_bar[kFv] += tau_bar * s[0];
    theta_bar[kV0] -= r_bar * r / theta[kV0];
    s_bar[0] += r_bar / theta[kV0] + tau_bar * theta[kFv];
    stribeck_curve_pullback(theta[kFc], theta[kFs], theta[kVs], s[0], level, tau_bar * t, S(0),
                            theta_bar[kFc], theta_bar[kFs], theta_bar[kVs], s_bar[0]);
  }

  template <class S>
  void step_pullback(const S* theta, const Input<S>& in, double dt, const S* s, const S* s_next_bar,
                     S* theta_bar, Input<S>& in_bar, S* s_bar) const {
    const auto rests = in.v == S(0);
    const S x = S(dt) / theta[kLag], settled = -expm1(-x);
    const S bar = select(rests, S(0), s_next_bar[0]);
    s_bar[0] += select(rests, s_next_bar[0], bar * (S(1) - settled));
    in_bar.v += bar * settled;
    // d settled/dT = -e^-x x/T
    theta_bar[kLag] -= bar * (in.v - s[0]) * (S(1) - settled) * x / theta[kLag];
  }

  template <class S>
  S steady_torque(const S* theta, const Input<S>& in) const {
    return torque_of(theta, in.v);
  }

  void state_bound(const double*, double fastest, double* bound) const { bound[0] = fastest; }

 private:
  template <class S>
  static StribeckCurve<S> curve(const S* theta, const S& s) {
    return stribeck_curve(theta[kFc], theta[kFs], theta[kVs], s);
  }
  template <class S>
  static S torque_of(const S* theta, const S& s) {
    return curve(theta, s).value * tanh(s / theta[kV0]) + theta[kFv] * s;
  }

  static constexpr std::array<ParameterInfo, kSize> kParameters{{
      {"Fc", "N m", Role::kCoulomb, 1e-6, 1e6, 5, Scale::kLog, "Coulomb friction"},
      {"Fs", "N m", Role::kStatic, 1e-6, 1e6, 5.5, Scale::kLog, "static friction"},
      {"vs", "rad/s", Role::kStribeckVelocity, 1e-4, 10, 0.06, Scale::kLog, "Stribeck velocity"},
      {"Fv", "N m s/rad", Role::kViscous, 0, 1e6, 2.5, Scale::kLinear, "viscous friction"},
      {"v0", "rad/s", Role::kSmoothingSpeed, 1e-5, 1, 0.01, Scale::kLog,
       "speed over which the sign of s is smoothed"},
      {"T", "s", Role::kLag, 1e-5, 1, 5e-3, Scale::kLog, "lag of friction behind speed"},
  }};
};

}  // namespace fricid::friction
