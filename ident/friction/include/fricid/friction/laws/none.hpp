#pragma once

#include <span>
#include <string_view>

#include "fricid/friction/law.hpp"

namespace fricid::friction {

/// No friction: tau = 0.
class None : public Stateless {
 public:
  static constexpr std::string_view kName = "none";
  static constexpr std::string_view kEquation = "tau = 0";
  static constexpr std::string_view kSource = "-";
  static constexpr PlotLook kLook{"#708090", 3};
  static constexpr Claims kClaims{};
  static constexpr Reads kReads{};
  static constexpr int kMostElements = 0;

  static constexpr std::span<const ParameterInfo> parameters() { return {}; }

  template <class S>
  S torque(const S*, const Input<S>&, const S*) const {
    return S(0);
  }
  template <class S>
  void torque_pullback(const S*, const Input<S>&, const S*, const S&, S*, Input<S>&, S*) const {}
  template <class S>
  S steady_torque(const S*, const Input<S>&) const {
    return S(0);
  }
};

}  // namespace fricid::friction
