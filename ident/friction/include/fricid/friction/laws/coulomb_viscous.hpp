#pragma once

#include <array>
#include <span>
#include <string_view>

#include "fricid/base/math.hpp"
#include "fricid/friction/law.hpp"

namespace fricid::friction {

/// Coulomb and viscous friction, smooth through v = 0:
///
///     tau = Fc tanh(v/v0) + Fv v
///
/// Why v0 and not sign(v): a host that holds tau over a step dt turns a sign into chatter, because
/// each step overshoots v = 0 and the torque comes back with full size. With v0 the slope at rest
/// is Fc/v0, and an inertia M [kg m2] settles instead of chattering when Fc dt / (M v0) < 2. The
/// price is creep: a torque below Fc moves the joint at v = v0 artanh(tau/Fc).
class CoulombViscous : public Stateless {
 public:
  enum Index { kFc, kFv, kV0, kSize };

  static constexpr std::string_view kName = "coulomb_viscous";
  static constexpr std::string_view kEquation = "tau = Fc tanh(v/v0) + Fv v";
  static constexpr std::string_view kSource =
      "Coulomb 1785; smoothing as in Andersson et al., Tribology Int. 40, 2007";
  static constexpr PlotLook kLook{"#CC79A7", 9};
  static constexpr Claims kClaims{};
  static constexpr Reads kReads{};
  static constexpr int kMostElements = 0;

  static constexpr std::span<const ParameterInfo> parameters() { return kParameters; }

  template <class S>
  S torque(const S* theta, const Input<S>& in, const S*) const {
    return theta[kFc] * tanh(in.v / theta[kV0]) + theta[kFv] * in.v;
  }

  template <class S>
  void torque_pullback(const S* theta, const Input<S>& in, const S*, const S& tau_bar, S* theta_bar,
                       Input<S>& in_bar, S*) const {
    const S r = in.v / theta[kV0];
    const S t = tanh(r);
    const S r_bar = tau_bar * theta[kFc] * (S(1) - t * t);
    theta_bar[kFc] += tau_bar * t;
    theta_bar[kFv] += tau_bar * in.v;
    theta_bar[kV0] -= r_bar * r / theta[kV0];
    in_bar.v += r_bar / theta[kV0] + tau_bar * theta[kFv];
  }

  template <class S>
  S steady_torque(const S* theta, const Input<S>& in) const {
    return torque<S>(theta, in, nullptr);
  }

 private:
  static constexpr std::array<ParameterInfo, kSize> kParameters{{
      {"Fc", "N m", Role::kCoulomb, 1e-6, 1e6, 5, Scale::kLog, "Coulomb friction"},
      {"Fv", "N m s/rad", Role::kViscous, 0, 1e6, 2.5, Scale::kLinear, "viscous coefficient"},
      {"v0", "rad/s", Role::kSmoothingSpeed, 1e-5, 1, 0.01, Scale::kLog, "smoothing speed"},
  }};
};

}  // namespace fricid::friction
