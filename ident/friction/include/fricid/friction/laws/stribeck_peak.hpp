#pragma once

#include <array>
#include <span>
#include <string_view>

#include "fricid/base/math.hpp"
#include "fricid/friction/law.hpp"
#include "fricid/friction/stribeck_curve.hpp"

namespace fricid::friction {

/// The part of static friction that is lost with speed, without memory, to stand beside a law that
/// has one:
///
///     tau = Ts exp(-(v/vs)^2) tanh(v/v0)
///
/// v0 smooths the sign of v, see coulomb_viscous. Its slope is negative above about v0, see
/// stribeck.
class StribeckPeak : public Stateless {
 public:
  enum Index { kTs, kVs, kV0, kSize };

  static constexpr std::string_view kName = "stribeck_peak";
  static constexpr std::string_view kEquation = "tau = Ts exp(-(v/vs)^2) tanh(v/v0)";
  static constexpr std::string_view kSource = "the falling term of stribeck alone";
  static constexpr PlotLook kLook{"#999933", 13};
  static constexpr Claims kClaims{};
  static constexpr Reads kReads{};
  static constexpr int kMostElements = 0;

  static constexpr std::span<const ParameterInfo> parameters() { return kParameters; }

  template <class S>
  S torque(const S* theta, const Input<S>& in, const S*) const {
    return curve(theta, in.v).value * tanh(in.v / theta[kV0]);
  }

  template <class S>
  void torque_pullback(const S* theta, const Input<S>& in, const S*, const S& tau_bar, S* theta_bar,
                       Input<S>& in_bar, S*) const {
    const StribeckCurve<S> s = curve(theta, in.v);
    const S r = in.v / theta[kV0];
    const S t = tanh(r);
    const S r_bar = tau_bar * s.value * (S(1) - t * t);
    S Fc_bar(0);
    theta_bar[kV0] -= r_bar * r / theta[kV0];
    in_bar.v += r_bar / theta[kV0];
    stribeck_curve_pullback(S(0), theta[kTs], theta[kVs], in.v, s, tau_bar * t, S(0), Fc_bar,
                            theta_bar[kTs], theta_bar[kVs], in_bar.v);
  }

  template <class S>
  S steady_torque(const S* theta, const Input<S>& in) const {
    return torque<S>(theta, in, nullptr);
  }

 private:
  template <class S>
  static StribeckCurve<S> curve(const S* theta, const S& v) {
    return stribeck_curve(S(0), theta[kTs], theta[kVs], v);
  }

  static constexpr std::array<ParameterInfo, kSize> kParameters{{
      {"Ts", "N m", Role::kStatic, 0, 1e6, 1, Scale::kLinear,
       "torque at rest that speed takes away"},
      {"vs", "rad/s", Role::kStribeckVelocity, 1e-4, 10, 0.05, Scale::kLog, "Stribeck velocity"},
      {"v0", "rad/s", Role::kSmoothingSpeed, 1e-5, 1, 0.01, Scale::kLog, "smoothing speed"},
  }};
};

}  // namespace fricid::friction
