#pragma once

#include <array>
#include <span>
#include <string_view>

#include "fricid/base/math.hpp"
#include "fricid/friction/law.hpp"

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
    const S u = in.v / theta[kVs];
    return theta[kTs] * exp(-(u * u)) * tanh(in.v / theta[kV0]);
  }

  template <class S>
  void torque_pullback(const S* theta, const Input<S>& in, const S*, const S& tau_bar, S* theta_bar,
                       Input<S>& in_bar, S*) const {
    const S u = in.v / theta[kVs], r = in.v / theta[kV0];
    const S peak = exp(-(u * u)), t = tanh(r);
    const S u_bar = -tau_bar * theta[kTs] * t * S(2) * u * peak;
    const S r_bar = tau_bar * theta[kTs] * peak * (S(1) - t * t);
    theta_bar[kTs] += tau_bar * peak * t;
    theta_bar[kVs] -= u_bar * u / theta[kVs];
    theta_bar[kV0] -= r_bar * r / theta[kV0];
    in_bar.v += u_bar / theta[kVs] + r_bar / theta[kV0];
  }

  template <class S>
  S steady_torque(const S* theta, const Input<S>& in) const {
    return torque<S>(theta, in, nullptr);
  }

 private:
  static constexpr std::array<ParameterInfo, kSize> kParameters{{
      {"Ts", "N m", Role::kStatic, 0, 1e4, 1, Scale::kLinear,
       "torque at rest that speed takes away"},
      {"vs", "rad/s", Role::kStribeckVelocity, 1e-4, 10, 0.05, Scale::kLog, "Stribeck velocity"},
      {"v0", "rad/s", Role::kSmoothingSpeed, 1e-5, 1, 0.01, Scale::kLog, "smoothing speed"},
  }};
};

}  // namespace fricid::friction
