#pragma once

#include <array>
#include <span>
#include <string_view>

#include "fricid/base/math.hpp"
#include "fricid/friction/law.hpp"

namespace fricid::friction {

/// Friction that grows with the torque that the gear hands to the link. Of the torque `load` of the
/// motor, this friction itself and c v, viscous friction on the motor's side, do not reach it:
///
///     tau' = (1 + mu |l|) tau,     l = load - tau' - c v
///     =>  l = d / max(1 + mu tau sgn d, 1/10),     d = load - tau - c v
///
/// A gear that locks itself (mu |tau| towards 1 when driven by its load) is held at ten times d.
/// The torque that accelerates the motor's inertia counts as handed on.
class GearLoad {
 public:
  enum Index { kMu, kC, kSize };

  static constexpr std::string_view kName = "gear_load";
  static constexpr std::string_view kEquation = "tau' = (1 + mu |l|) tau, l = load - tau' - c v";
  static constexpr std::string_view kSource =
      "Hamon, Gautier & Garrec, Dynamic identification of robots with a dry friction model "
      "depending "
      "on load and velocity, IROS 2010";
  static constexpr Claims kClaims{};
  static constexpr Reads kReads{.load = true};
  static constexpr int kMostElements = 0;

  static constexpr int state_size() { return 0; }
  static constexpr std::span<const ParameterInfo> parameters() { return kParameters; }

  template <class S>
  S apply(const S* theta, const Input<S>& in, const S& tau) const {
    return (S(1) + theta[kMu] * abs(terms(theta, in, tau).l)) * tau;
  }

  template <class S>
  void apply_pullback(const S* theta, const Input<S>& in, const S& tau, const S& out_bar,
                      S* theta_bar, Input<S>& in_bar, S& tau_bar) const {
    const Terms<S> x = terms(theta, in, tau);
    const S side = sign(x.d);
    const S l_bar = out_bar * tau * theta[kMu] * side;
    const S d_bar = l_bar / x.share;
    const S share_bar = select(x.share > S(kLeastShare), -d_bar * x.l, S(0));
    theta_bar[kMu] += out_bar * tau * abs(x.l) + share_bar * tau * side;
    theta_bar[kC] -= d_bar * in.v;
    in_bar.load += d_bar;
    in_bar.v -= d_bar * theta[kC];
    tau_bar += out_bar * (S(1) + theta[kMu] * abs(x.l)) + share_bar * theta[kMu] * side - d_bar;
  }

 private:
  static constexpr double kLeastShare = 0.1;

  template <class S>
  struct Terms {
    S d, share, l;
  };

  template <class S>
  static Terms<S> terms(const S* theta, const Input<S>& in, const S& tau) {
    Terms<S> x;
    x.d = in.load - tau - theta[kC] * in.v;
    x.share = max(S(kLeastShare), S(1) + theta[kMu] * tau * sign(x.d));
    x.l = x.d / x.share;
    return x;
  }

  static constexpr std::array<ParameterInfo, kSize> kParameters{{
      {"mu", "1/(N m)", Role::kLoadGrowth, 0, 1, 0.005, Scale::kLinear,
       "relative growth per N m handed on"},
      {"c", "N m s/rad", Role::kMotorViscous, 0, 1e6, 2, Scale::kLinear,
       "viscous friction on the motor's side"},
  }};
};

}  // namespace fricid::friction
