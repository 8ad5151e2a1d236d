#pragma once

#include <array>
#include <span>
#include <string_view>

#include "fricid/base/math.hpp"
#include "fricid/friction/bristle.hpp"
#include "fricid/friction/law.hpp"

namespace fricid::friction {

/// Dahl's law (exponent 1) with viscous friction:
///
///     dz/dt = v - |v| z / z_c,   z_c = Fc/sigma0
///     tau   = sigma0 z + Fv v
///
/// Rate independent but for Fv: after a reversal the torque climbs back to Fc with the e-fold z_c
/// of travel. `step` is exact for held v. State: z (1), bristle deflection [rad], |z| <= z_c.
class Dahl {
 public:
  enum Index { kFc, kSigma0, kFv, kSize };

  static constexpr std::string_view kName = "dahl";
  static constexpr std::string_view kEquation =
      "dz/dt = v - sigma0 |v| z / Fc; tau = sigma0 z + Fv v";
  static constexpr std::string_view kSource = "Dahl, AIAA Journal 14(12), 1976";
  static constexpr PlotLook kLook{"#56B4E9", 5};
  static constexpr Claims kClaims{};
  static constexpr Reads kReads{};
  static constexpr int kMostElements = 0;
  static constexpr std::string_view kStateUnit = "rad";

  static constexpr int state_size() { return 1; }
  static constexpr std::span<const ParameterInfo> parameters() { return kParameters; }

  template <class S>
  S torque(const S* theta, const Input<S>& in, const S* z) const {
    return theta[kSigma0] * z[0] + theta[kFv] * in.v;
  }

  template <class S>
  void step(const S* theta, const Input<S>& in, double dt, S* z) const {
    z[0] = bristle_step(in.v, decay_rate(theta, in.v), dt, z[0]);
  }

  template <class S>
  void torque_pullback(const S* theta, const Input<S>& in, const S* z, const S& tau_bar,
                       S* theta_bar, Input<S>& in_bar, S* z_bar) const {
    theta_bar[kSigma0] += tau_bar * z[0];
    theta_bar[kFv] += tau_bar * in.v;
    in_bar.v += tau_bar * theta[kFv];
    z_bar[0] += tau_bar * theta[kSigma0];
  }

  template <class S>
  void step_pullback(const S* theta, const Input<S>& in, double dt, const S* z, const S* z_next_bar,
                     S* theta_bar, Input<S>& in_bar, S* z_bar) const {
    const S r = decay_rate(theta, in.v);
    const BristleBar<S> bar = bristle_step_pullback(in.v, r, dt, z[0], z_next_bar[0]);
    const S speed_over_Fc = abs(in.v) / theta[kFc];
    theta_bar[kSigma0] += bar.r * speed_over_Fc;
    theta_bar[kFc] -= bar.r * r / theta[kFc];
    in_bar.v += bar.v + bar.r * theta[kSigma0] / theta[kFc] * sign(in.v);
    z_bar[0] += bar.z;
  }

  /// v = 0 returns 0.
  template <class S>
  S steady_torque(const S* theta, const Input<S>& in) const {
    return theta[kFc] * sign(in.v) + theta[kFv] * in.v;
  }

  void state_bound(const double* theta, double, double* bound) const {
    bound[0] = theta[kFc] / theta[kSigma0];
  }

 private:
  template <class S>  // |v| / z_c  [1/s]
  static S decay_rate(const S* theta, const S& v) {
    return theta[kSigma0] * abs(v) / theta[kFc];
  }

  static constexpr std::array<ParameterInfo, kSize> kParameters{{
      {"Fc", "N m", Role::kCoulomb, 1e-6, 1e6, 5, Scale::kLog, "Coulomb friction"},
      {"sigma0", "N m/rad", Role::kStiffness, 1e-2, 1e9, 1.5e4, Scale::kLog, "bristle stiffness"},
      {"Fv", "N m s/rad", Role::kViscous, 0, 1e6, 2.5, Scale::kLinear, "viscous coefficient"},
  }};
};

}  // namespace fricid::friction
