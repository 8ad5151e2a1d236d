#pragma once

#include <algorithm>
#include <array>
#include <span>
#include <string_view>

#include "fricid/base/math.hpp"
#include "fricid/friction/bristle.hpp"
#include "fricid/friction/law.hpp"
#include "fricid/friction/stribeck_curve.hpp"

namespace fricid::friction {

/// Whether bristle damping fades with speed (kFading) or is constant as in 1995 (kConstant).
enum class BristleDamping { kFading, kConstant };

/// LuGre (their g is g/sigma0 here):
///
///     dz/dt = v - r z,  r = sigma0 |v| / g(v),  g(v) = Fc + (Fs - Fc) exp(-(v/vs)^2)
///     tau   = sigma0 z + sigma1(v) dz/dt + sigma2 v
///     sigma1(v) = sigma1 exp(-(v/vs)^2)   (lugre)   or   sigma1   (lugre_classic)
///
/// Friction takes energy in every state if sigma1(v) |v| <= 4 g(v) (write the balance of the energy
/// sigma0 z^2/2 as a quadratic form in dz/dt and r z). Constant damping breaks that above
/// |v| = 4 Fc/sigma1, a speed that robots reach; fading damping keeps it at every speed when
/// sigma1 vs <= 9 min(Fc, Fs). `step` is exact for held v.
/// State: z (1), mean bristle deflection [rad], |z| <= max(Fc, Fs)/sigma0.
template <BristleDamping damping>
class BasicLuGre {
 public:
  enum Index { kFc, kFs, kVs, kSigma0, kSigma1, kSigma2, kSize };

  static constexpr bool kFades = damping == BristleDamping::kFading;
  static constexpr std::string_view kName = kFades ? "lugre" : "lugre_classic";
  static constexpr std::string_view kEquation =
      kFades ? "dz/dt = v - sigma0 |v| z / g(v); tau = sigma0 z + sigma1 exp(-(v/vs)^2) dz/dt + "
               "sigma2 v; g(v) = Fc + (Fs - Fc) exp(-(v/vs)^2)"
             : "as lugre with constant sigma1";
  static constexpr std::string_view kSource =
      kFades ? "Canudas de Wit et al., IEEE TAC 40(3), 1995; damping after Olsson et al., Eur. J. "
               "Control 4, 1998"
             : "Canudas de Wit et al., IEEE TAC 40(3), 1995";
  static constexpr PlotLook kLook = kFades ? PlotLook{"#009E73", 13} : PlotLook{"#66A61E", 12};
  static constexpr Claims kClaims{.dissipative = kFades};
  static constexpr Reads kReads{};
  static constexpr int kMostElements = 0;
  static constexpr std::string_view kStateUnit = "rad";

  static constexpr int state_size() { return 1; }
  static constexpr std::span<const ParameterInfo> parameters() { return kParameters; }

  template <class S>
  S torque(const S* theta, const Input<S>& in, const S* z) const {
    const StribeckCurve<S> g = curve(theta, in.v);
    return torque_at(theta, in.v, g, bristle_of(theta, g), z[0]);
  }

  template <class S>
  void step(const S* theta, const Input<S>& in, double dt, S* z) const {
    const Bristle<S> bristle = bristle_of(theta, curve(theta, in.v));
    z[0] = bristle_settle(bristle.level, in.v * bristle.per_level * S(dt), z[0]);
  }

  /// `step`, then `torque`, which share the Stribeck curve.
  template <class S>
  S step_torque(const S* theta, const Input<S>& in, double dt, S* z) const {
    const StribeckCurve<S> g = curve(theta, in.v);
    const Bristle<S> bristle = bristle_of(theta, g);
    z[0] = bristle_settle(bristle.level, in.v * bristle.per_level * S(dt), z[0]);
    return torque_at(theta, in.v, g, bristle, z[0]);
  }

  template <class S>
  void torque_pullback(const S* theta, const Input<S>& in, const S* z, const S& tau_bar,
                       S* theta_bar, Input<S>& in_bar, S* z_bar) const {
    const StribeckCurve<S> g = curve(theta, in.v);
    const S r = decay_rate(in.v, bristle_of(theta, g));
    const S sigma1 = bristle_damping(theta, g);
    const S dz = in.v - r * z[0];
    theta_bar[kSigma0] += tau_bar * z[0];
    theta_bar[kSigma2] += tau_bar * in.v;
    theta_bar[kSigma1] += tau_bar * dz * (kFades ? g.e : S(1));
    in_bar.v += tau_bar * (sigma1 + theta[kSigma2]);
    z_bar[0] += tau_bar * (theta[kSigma0] - sigma1 * r);
    const S e_bar = kFades ? tau_bar * dz * theta[kSigma1] : S(0);
    rate_pullback(theta, in.v, g, r, -tau_bar * sigma1 * z[0], e_bar, theta_bar, in_bar.v);
  }

  template <class S>
  void step_pullback(const S* theta, const Input<S>& in, double dt, const S* z, const S* z_next_bar,
                     S* theta_bar, Input<S>& in_bar, S* z_bar) const {
    const StribeckCurve<S> g = curve(theta, in.v);
    const S r = decay_rate(in.v, bristle_of(theta, g));
    const BristleBar<S> bar = bristle_step_pullback(in.v, r, dt, z[0], z_next_bar[0]);
    in_bar.v += bar.v;
    z_bar[0] += bar.z;
    rate_pullback(theta, in.v, g, r, bar.r, S(0), theta_bar, in_bar.v);
  }

  /// v = 0 returns 0.
  template <class S>
  S steady_torque(const S* theta, const Input<S>& in) const {
    return curve(theta, in.v).value * sign(in.v) + theta[kSigma2] * in.v;
  }

  void state_bound(const double* theta, double, double* bound) const {
    bound[0] = std::max(theta[kFc], theta[kFs]) / theta[kSigma0];
  }

 private:
  template <class S>
  static StribeckCurve<S> curve(const S* theta, const S& v) {
    return stribeck_curve(theta[kFc], theta[kFs], theta[kVs], v);
  }

  template <class S>
  struct Bristle {
    S level;      // g / sigma0 [rad]
    S per_level;  // sigma0 / g [1/rad]
  };
  template <class S>  // with one division
  static Bristle<S> bristle_of(const S* theta, const StribeckCurve<S>& g) {
    const S inverse = S(1) / (theta[kSigma0] * g.value);
    return {g.value * g.value * inverse, theta[kSigma0] * theta[kSigma0] * inverse};
  }

  template <class S>
  static S torque_at(const S* theta, const S& v, const StribeckCurve<S>& g,
                     const Bristle<S>& bristle, const S& z) {
    const S dz = v - decay_rate(v, bristle) * z;
    return theta[kSigma0] * z + bristle_damping(theta, g) * dz + theta[kSigma2] * v;
  }

  template <class S>  // r [1/s]
  static S decay_rate(const S& v, const Bristle<S>& bristle) {
    return abs(v) * bristle.per_level;
  }

  template <class S>  // sigma1(v) [N m s/rad]
  static S bristle_damping(const S* theta, const StribeckCurve<S>& g) {
    return kFades ? theta[kSigma1] * g.e : theta[kSigma1];
  }

  // pulls r_bar, and e_bar from elsewhere, back to theta and v
  template <class S>
  static void rate_pullback(const S* theta, const S& v, const StribeckCurve<S>& g, const S& r,
                            const S& r_bar, const S& e_bar, S* theta_bar, S& v_bar) {
    theta_bar[kSigma0] += r_bar * abs(v) / g.value;
    v_bar += r_bar * theta[kSigma0] * sign(v) / g.value;
    stribeck_curve_pullback(theta[kFc], theta[kFs], theta[kVs], v, g, -r_bar * r / g.value, e_bar,
                            theta_bar[kFc], theta_bar[kFs], theta_bar[kVs], v_bar);
  }

  static constexpr std::array<ParameterInfo, kSize> kParameters{{
      {"Fc", "N m", Role::kCoulomb, 1e-6, 1e6, 5, Scale::kLog, "Coulomb friction"},
      {"Fs", "N m", Role::kStatic, 1e-6, 1e6, 6, Scale::kLog, "static friction"},
      {"vs", "rad/s", Role::kStribeckVelocity, 1e-4, 10, 0.05, Scale::kLog, "Stribeck velocity"},
      {"sigma0", "N m/rad", Role::kStiffness, 1e-2, 1e9, 1.5e4, Scale::kLog, "bristle stiffness"},
      {"sigma1", "N m s/rad", Role::kDamping, 0, 1e6, 30, Scale::kLinear, "bristle damping"},
      {"sigma2", "N m s/rad", Role::kViscous, 0, 1e6, 2.5, Scale::kLinear, "viscous coefficient"},
  }};
};

using LuGre = BasicLuGre<BristleDamping::kFading>;
using LuGreClassic = BasicLuGre<BristleDamping::kConstant>;

}  // namespace fricid::friction
