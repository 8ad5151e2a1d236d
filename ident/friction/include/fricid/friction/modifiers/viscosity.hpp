#pragma once

#include <array>
#include <span>
#include <string_view>

#include "fricid/base/math.hpp"
#include "fricid/friction/law.hpp"

namespace fricid::friction {

/// Temperature dependence of the viscous part of a law, whose coefficient at T0 is Fv; the rest of
/// the law is unchanged:
///
///     tau' = tau + Fv (exp(-beta (T - T0)) - 1) v
///
/// Viscous friction falls by some percent per kelvin, Coulomb friction by less than one:
/// `temperature` alone, one factor for the whole law, cannot represent both. Above T0 the modifier
/// reduces the torque; if it takes more than the law has, friction drives the joint.
class Viscosity {
 public:
  enum Index { kFv, kBeta, kT0, kSize };

  static constexpr std::string_view kName = "viscosity";
  static constexpr std::string_view kEquation = "tau' = tau + Fv (exp(-beta (T - T0)) - 1) v";
  static constexpr std::string_view kSource =
      "Bittencourt & Gunnarsson, J. Dyn. Syst. Meas. Control 134, 2012";
  static constexpr Claims kClaims{.dissipative = false};
  static constexpr Reads kReads{.temperature = true};
  static constexpr int kMostElements = 0;

  static constexpr int state_size() { return 0; }
  static constexpr std::span<const ParameterInfo> parameters() { return kParameters; }

  template <class S>
  S apply(const S* theta, const Input<S>& in, const S& tau) const {
    return tau + theta[kFv] * (thinning(theta, in) - S(1)) * in.v;
  }

  template <class S>
  void apply_pullback(const S* theta, const Input<S>& in, const S&, const S& out_bar, S* theta_bar,
                      Input<S>& in_bar, S& tau_bar) const {
    const S left = thinning(theta, in);
    const S exponent_bar = out_bar * theta[kFv] * in.v * left;
    theta_bar[kFv] += out_bar * (left - S(1)) * in.v;
    theta_bar[kBeta] -= exponent_bar * (in.temperature - theta[kT0]);
    theta_bar[kT0] += exponent_bar * theta[kBeta];
    in_bar.temperature -= exponent_bar * theta[kBeta];
    in_bar.v += out_bar * theta[kFv] * (left - S(1));
    tau_bar += out_bar;
  }

 private:
  template <class S>  // share of the viscous friction at T0
  static S thinning(const S* theta, const Input<S>& in) {
    return exp(-theta[kBeta] * (in.temperature - theta[kT0]));
  }

  static constexpr std::array<ParameterInfo, kSize> kParameters{{
      {"Fv", "N m s/rad", Role::kViscous, 0, 1e6, 2.5, Scale::kLinear,
       "temperature-dependent viscous coefficient, at T0"},
      {"beta", "1/K", Role::kTemperatureCoefficient, -0.01, 0.1, 0.02, Scale::kLinear,
       "relative decrease per kelvin"},
      {"T0", "K", Role::kTemperature, 250, 400, 313.15, Scale::kLinear,
       "reference temperature of the law"},
  }};
};

}  // namespace fricid::friction
