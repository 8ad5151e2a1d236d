#pragma once

#include <array>
#include <span>
#include <string_view>

#include "fricid/base/math.hpp"
#include "fricid/friction/law.hpp"

namespace fricid::friction {

/// Viscous friction that grows like a power of speed:
///
///     tau = c v (v^2 + v0^2)^((p-1)/2)      -> c |v|^p sign(v) for |v| >> v0
///
/// For p < 1 the pure power has an infinite slope at v = 0; v0 makes it c v0^(p-1), finite, so that
/// a host with finite step stays stable.
class ViscousPower : public Stateless {
 public:
  enum Index { kC, kP, kV0, kSize };

  static constexpr std::string_view kName = "viscous_power";
  static constexpr std::string_view kEquation = "tau = c v (v^2 + v0^2)^((p-1)/2)";
  static constexpr std::string_view kSource =
      "nonlinear viscous friction of strain-wave gears: Wolf & Iskandar, ICRA 2018";
  static constexpr PlotLook kLook{"#44AA99", 10};
  static constexpr Claims kClaims{};
  static constexpr Reads kReads{};
  static constexpr int kMostElements = 0;

  static constexpr std::span<const ParameterInfo> parameters() { return kParameters; }

  template <class S>
  S torque(const S* theta, const Input<S>& in, const S*) const {
    return theta[kC] * in.v * attenuation(theta, in.v);
  }

  template <class S>
  void torque_pullback(const S* theta, const Input<S>& in, const S*, const S& tau_bar, S* theta_bar,
                       Input<S>& in_bar, S*) const {
    const S m = attenuation(theta, in.v);
    const S m_bar = tau_bar * theta[kC] * in.v;
    // m = w^((p-1)/2), w = v^2 + v0^2
    const S w = in.v * in.v + theta[kV0] * theta[kV0];
    const S w_bar = m_bar * S(0.5) * (theta[kP] - S(1)) * m / w;
    theta_bar[kC] += tau_bar * in.v * m;
    theta_bar[kP] += m_bar * m * S(0.5) * log(w);
    theta_bar[kV0] += w_bar * S(2) * theta[kV0];
    in_bar.v += tau_bar * theta[kC] * m + w_bar * S(2) * in.v;
  }

  template <class S>
  S steady_torque(const S* theta, const Input<S>& in) const {
    return torque<S>(theta, in, nullptr);
  }

 private:
  template <class S>
  static S attenuation(const S* theta, const S& v) {
    return exp(S(0.5) * (theta[kP] - S(1)) * log(v * v + theta[kV0] * theta[kV0]));
  }

  static constexpr std::array<ParameterInfo, kSize> kParameters{{
      {"c", "N m (s/rad)^p", Role::kPowerViscous, 0, 1e6, 3, Scale::kLinear, "torque at 1 rad/s"},
      {"p", "1", Role::kExponent, 0.2, 2, 0.8, Scale::kLinear, "exponent"},
      {"v0", "rad/s", Role::kSmoothingSpeed, 1e-5, 1, 0.01, Scale::kLog,
       "speed below which the law is linear"},
  }};
};

}  // namespace fricid::friction
