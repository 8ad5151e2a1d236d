#pragma once

#include <array>
#include <span>
#include <string_view>

#include "fricid/friction/law.hpp"

namespace fricid::friction {

/// Linear viscous friction alone, a part of sums: tau = Fv v.
class Viscous : public Stateless {
 public:
  enum Index { kFv, kSize };

  static constexpr std::string_view kName = "viscous";
  static constexpr std::string_view kEquation = "tau = Fv v";
  static constexpr std::string_view kSource = "Newton 1687";
  static constexpr PlotLook kLook{"#117733", 8};
  static constexpr Claims kClaims{};
  static constexpr Reads kReads{};
  static constexpr int kMostElements = 0;

  static constexpr std::span<const ParameterInfo> parameters() { return kParameters; }

  template <class S>
  S torque(const S* theta, const Input<S>& in, const S*) const {
    return theta[kFv] * in.v;
  }

  template <class S>
  void torque_pullback(const S* theta, const Input<S>& in, const S*, const S& tau_bar, S* theta_bar,
                       Input<S>& in_bar, S*) const {
    theta_bar[kFv] += tau_bar * in.v;
    in_bar.v += tau_bar * theta[kFv];
  }

  template <class S>
  S steady_torque(const S* theta, const Input<S>& in) const {
    return torque<S>(theta, in, nullptr);
  }

 private:
  static constexpr std::array<ParameterInfo, kSize> kParameters{{
      {"Fv", "N m s/rad", Role::kViscous, 0, 1e6, 2.5, Scale::kLinear, "viscous coefficient"},
  }};
};

}  // namespace fricid::friction
