#pragma once

#include <array>
#include <span>
#include <string_view>

#include "fricid/base/math.hpp"
#include "fricid/friction/law.hpp"

namespace fricid::friction {

/// Friction that grows with the torque through the gear:
///
///     tau' = (1 + mu |load|) tau
///
/// mu is per N m of load and relative to the law, so Coulomb friction Fc gains mu Fc per N m.
class LoadModifier {
 public:
  enum Index { kMu, kSize };

  static constexpr std::string_view kName = "load";
  static constexpr std::string_view kEquation = "tau' = (1 + mu |load|) tau";
  static constexpr std::string_view kSource =
      "Bittencourt & Gunnarsson, J. Dyn. Syst. Meas. Control 134, 2012";
  static constexpr Claims kClaims{};
  static constexpr Reads kReads{.load = true};
  static constexpr int kMostElements = 0;

  static constexpr int state_size() { return 0; }
  static constexpr std::span<const ParameterInfo> parameters() { return kParameters; }

  template <class S>
  S apply(const S* theta, const Input<S>& in, const S& tau) const {
    return (S(1) + theta[kMu] * abs(in.load)) * tau;
  }

  template <class S>
  void apply_pullback(const S* theta, const Input<S>& in, const S& tau, const S& out_bar,
                      S* theta_bar, Input<S>& in_bar, S& tau_bar) const {
    const S factor_bar = out_bar * tau;
    theta_bar[kMu] += factor_bar * abs(in.load);
    in_bar.load += factor_bar * theta[kMu] * sign(in.load);
    tau_bar += out_bar * (S(1) + theta[kMu] * abs(in.load));
  }

 private:
  static constexpr std::array<ParameterInfo, kSize> kParameters{{
      {"mu", "1/(N m)", Role::kLoadGrowth, 0, 1, 0.005, Scale::kLinear,
       "relative growth per N m of load"},
  }};
};

}  // namespace fricid::friction
