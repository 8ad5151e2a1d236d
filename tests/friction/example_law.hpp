#pragma once

#include <array>
#include <span>
#include <string_view>

#include "fricid/base/math.hpp"
#include "fricid/friction/bristle.hpp"
#include "fricid/friction/law.hpp"

namespace fricid::friction {

/// A bristle whose level grows with speed, so that viscous friction builds up over travel too and
/// the torque has no jump where v has one:
///
///     dz/dt = v - r z,  r = sigma0 |v| / g(v),  g(v) = Fc + Fv |v|
///     tau   = sigma0 z
///
/// `step` is exact for held v. State: z (1), bristle deflection [rad].
class ViscousBristle {
 public:
  enum Index { kFc, kSigma0, kFv, kSize };

  static constexpr std::string_view kName = "viscous_bristle";
  static constexpr std::string_view kEquation =
      "dz/dt = v - sigma0 |v| z / (Fc + Fv |v|); tau = sigma0 z";
  static constexpr std::string_view kSource = "example of docs/add_a_friction_law.md";
  static constexpr PlotLook kLook{"#2F4F4F", 1};
  static constexpr Claims kClaims{};
  static constexpr Reads kReads{};
  static constexpr int kMostElements = 0;
  static constexpr std::string_view kStateUnit = "rad";

  static constexpr int state_size() { return 1; }
  static constexpr std::span<const ParameterInfo> parameters() { return kParameters; }

  template <class S>
  S torque(const S* theta, const Input<S>&, const S* z) const {
    return theta[kSigma0] * z[0];
  }

  template <class S>
  void step(const S* theta, const Input<S>& in, double dt, S* z) const {
    const S r = theta[kSigma0] * abs(in.v) / level(theta, in.v);
    z[0] = bristle_step(in.v, r, dt, z[0]);
  }

  template <class S>
  void torque_pullback(const S* theta, const Input<S>&, const S* z, const S& tau_bar, S* theta_bar,
                       Input<S>&, S* z_bar) const {
    theta_bar[kSigma0] += tau_bar * z[0];
    z_bar[0] += tau_bar * theta[kSigma0];
  }

  template <class S>
  void step_pullback(const S* theta, const Input<S>& in, double dt, const S* z, const S* z_next_bar,
                     S* theta_bar, Input<S>& in_bar, S* z_bar) const {
    const S speed = abs(in.v);
    const S g = level(theta, in.v);
    const S r = theta[kSigma0] * speed / g;
    const BristleBar<S> bar = bristle_step_pullback(in.v, r, dt, z[0], z_next_bar[0]);
    z_bar[0] += bar.z;

    const S g_bar = -bar.r * r / g;
    const S speed_bar = bar.r * theta[kSigma0] / g + g_bar * theta[kFv];
    theta_bar[kSigma0] += bar.r * speed / g;
    theta_bar[kFc] += g_bar;
    theta_bar[kFv] += g_bar * speed;
    in_bar.v += bar.v + speed_bar * sign(in.v);
  }

  template <class S>
  S steady_torque(const S* theta, const Input<S>& in) const {
    return level(theta, in.v) * sign(in.v);
  }

  void state_bound(const double* theta, double fastest, double* bound) const {
    bound[0] = level(theta, fastest) / theta[kSigma0];
  }

 private:
  template <class S>
  static S level(const S* theta, const S& v) {
    return theta[kFc] + theta[kFv] * abs(v);
  }

  static constexpr std::array<ParameterInfo, kSize> kParameters{{
      {"Fc", "N m", Role::kCoulomb, 1e-4, 1e4, 5, Scale::kLog, "Coulomb friction"},
      {"sigma0", "N m/rad", Role::kStiffness, 1, 1e8, 1.5e4, Scale::kLog, "bristle stiffness"},
      {"Fv", "N m s/rad", Role::kViscous, 0, 1e4, 2.5, Scale::kLinear,
       "growth of the level with speed"},
  }};
};

}  // namespace fricid::friction
