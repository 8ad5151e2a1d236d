#pragma once

#include <array>
#include <span>
#include <string_view>

#include "fricid/base/math.hpp"
#include "fricid/friction/law.hpp"

namespace fricid::friction {

/// Friction that is larger in one direction:
///
///     tau' = tau + a |tau|
///
/// The sign of the torque decides, not that of v: the result is continuous where a hysteretic
/// torque passes through zero after a reversal. In sliding both signs agree, and the levels are
/// those of the law times 1 + a and 1 - a.
class Asymmetry {
 public:
  enum Index { kA, kSize };

  static constexpr std::string_view kName = "asymmetry";
  static constexpr std::string_view kEquation = "tau' = tau + a |tau|";
  static constexpr std::string_view kSource =
      "direction-dependent Coulomb levels: Armstrong-Helouvry et al., Automatica 30(7), 1994";
  static constexpr Claims kClaims{.odd = false};
  static constexpr Reads kReads{};
  static constexpr int kMostElements = 0;

  static constexpr int state_size() { return 0; }
  static constexpr std::span<const ParameterInfo> parameters() { return kParameters; }

  template <class S>
  S apply(const S* theta, const Input<S>&, const S& tau) const {
    return tau + theta[kA] * abs(tau);
  }

  template <class S>
  void apply_pullback(const S* theta, const Input<S>&, const S& tau, const S& out_bar, S* theta_bar,
                      Input<S>&, S& tau_bar) const {
    theta_bar[kA] += out_bar * abs(tau);
    tau_bar += out_bar * (S(1) + theta[kA] * sign(tau));
  }

 private:
  static constexpr std::array<ParameterInfo, kSize> kParameters{{
      {"a", "1", Role::kAsymmetry, -0.7, 0.7, 0.05, Scale::kLinear,
       "half the relative difference of the directions"},
  }};
};

}  // namespace fricid::friction
