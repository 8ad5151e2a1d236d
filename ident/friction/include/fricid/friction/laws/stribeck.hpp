#pragma once

#include <array>
#include <span>
#include <string_view>

#include "fricid/base/math.hpp"
#include "fricid/friction/law.hpp"
#include "fricid/friction/stribeck_curve.hpp"

namespace fricid::friction {

/// Static friction that falls with speed (Stribeck effect) and viscous friction:
///
///     tau = s(v) tanh(v/v0) + Fv v,   s(v) = Fc + (Fs - Fc) exp(-(v/vs)^2)
///
/// v0 smooths the sign of v, see coulomb_viscous. The falling slope, down to about
/// -0.86 (Fs - Fc)/vs, is negative damping: a joint in open loop is unstable there.
class Stribeck : public Stateless {
 public:
  enum Index { kFc, kFs, kVs, kFv, kV0, kSize };

  static constexpr std::string_view kName = "stribeck";
  static constexpr std::string_view kEquation =
      "tau = (Fc + (Fs - Fc) exp(-(v/vs)^2)) tanh(v/v0) + Fv v";
  static constexpr std::string_view kSource =
      "Bo & Pavelescu, Wear 82, 1982; Armstrong-Helouvry et al., Automatica 30(7), 1994";
  static constexpr PlotLook kLook{"#E69F00", 11};
  static constexpr Claims kClaims{};
  static constexpr Reads kReads{};
  static constexpr int kMostElements = 0;

  static constexpr std::span<const ParameterInfo> parameters() { return kParameters; }

  template <class S>
  S torque(const S* theta, const Input<S>& in, const S*) const {
    return curve(theta, in.v).value * tanh(in.v / theta[kV0]) + theta[kFv] * in.v;
  }

  template <class S>
  void torque_pullback(const S* theta, const Input<S>& in, const S*, const S& tau_bar, S* theta_bar,
                       Input<S>& in_bar, S*) const {
    const StribeckCurve<S> s = curve(theta, in.v);
    const S r = in.v / theta[kV0];
    const S t = tanh(r);
    const S r_bar = tau_bar * s.value * (S(1) - t * t);
    theta_bar[kFv] += tau_bar * in.v;
    theta_bar[kV0] -= r_bar * r / theta[kV0];
    in_bar.v += r_bar / theta[kV0] + tau_bar * theta[kFv];
    stribeck_curve_pullback(theta[kFc], theta[kFs], theta[kVs], in.v, s, tau_bar * t, S(0),
                            theta_bar[kFc], theta_bar[kFs], theta_bar[kVs], in_bar.v);
  }

  template <class S>
  S steady_torque(const S* theta, const Input<S>& in) const {
    return torque<S>(theta, in, nullptr);
  }

 private:
  template <class S>
  static StribeckCurve<S> curve(const S* theta, const S& v) {
    return stribeck_curve(theta[kFc], theta[kFs], theta[kVs], v);
  }

  static constexpr std::array<ParameterInfo, kSize> kParameters{{
      {"Fc", "N m", Role::kCoulomb, 1e-6, 1e6, 5, Scale::kLog, "Coulomb friction"},
      {"Fs", "N m", Role::kStatic, 1e-6, 1e6, 6, Scale::kLog, "static friction"},
      {"vs", "rad/s", Role::kStribeckVelocity, 1e-4, 10, 0.05, Scale::kLog, "Stribeck velocity"},
      {"Fv", "N m s/rad", Role::kViscous, 0, 1e6, 2.5, Scale::kLinear, "viscous coefficient"},
      {"v0", "rad/s", Role::kSmoothingSpeed, 1e-5, 1, 0.01, Scale::kLog, "smoothing speed"},
  }};
};

}  // namespace fricid::friction
