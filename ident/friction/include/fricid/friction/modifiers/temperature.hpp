#pragma once

#include <array>
#include <span>
#include <string_view>

#include "fricid/base/math.hpp"
#include "fricid/friction/law.hpp"

namespace fricid::friction {

/// Friction that falls as the grease warms:
///
///     tau' = exp(-beta (T - T0)) tau
class Temperature {
 public:
  enum Index { kBeta, kT0, kSize };

  static constexpr std::string_view kName = "temperature";
  static constexpr std::string_view kEquation = "tau' = exp(-beta (T - T0)) tau";
  static constexpr std::string_view kSource =
      "Bittencourt & Gunnarsson, J. Dyn. Syst. Meas. Control 134, 2012";
  static constexpr Claims kClaims{};
  static constexpr Reads kReads{.temperature = true};
  static constexpr int kMostElements = 0;

  static constexpr int state_size() { return 0; }
  static constexpr std::span<const ParameterInfo> parameters() { return kParameters; }

  template <class S>
  S apply(const S* theta, const Input<S>& in, const S& tau) const {
    return factor(theta, in) * tau;
  }

  template <class S>
  void apply_pullback(const S* theta, const Input<S>& in, const S& tau, const S& out_bar,
                      S* theta_bar, Input<S>& in_bar, S& tau_bar) const {
    const S s = factor(theta, in);
    const S exponent_bar = out_bar * tau * s;
    theta_bar[kBeta] -= exponent_bar * (in.temperature - theta[kT0]);
    theta_bar[kT0] += exponent_bar * theta[kBeta];
    in_bar.temperature -= exponent_bar * theta[kBeta];
    tau_bar += out_bar * s;
  }

 private:
  template <class S>
  static S factor(const S* theta, const Input<S>& in) {
    return exp(-theta[kBeta] * (in.temperature - theta[kT0]));
  }

  static constexpr std::array<ParameterInfo, kSize> kParameters{{
      {"beta", "1/K", Role::kTemperatureCoefficient, -0.01, 0.1, 0.02, Scale::kLinear,
       "relative decrease per kelvin"},
      {"T0", "K", Role::kTemperature, 250, 400, 313.15, Scale::kLinear,
       "reference temperature of the law"},
  }};
};

}  // namespace fricid::friction
