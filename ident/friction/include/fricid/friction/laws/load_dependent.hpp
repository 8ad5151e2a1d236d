#pragma once

#include <array>
#include <span>
#include <string_view>

#include "fricid/base/math.hpp"
#include "fricid/friction/law.hpp"

namespace fricid::friction {

/// Coulomb friction that grows with the torque through the gear, differently when the motor drives
/// the load (load v > 0) and when the load drives the motor:
///
///     tau = (Fc + mu L + nu L^2) t + Fv v,     t = tanh(v/v0)
///     L   = sqrt(load^2 + l0^2) - l0,          d = t load / sqrt(load^2 + l0^2)
///     mu  = mu_m (1+d)/2 + mu_b (1-d)/2,       nu = nu_m (1+d)/2 + nu_b (1-d)/2
///
/// L is |load| with a smooth foot of width l0; d goes smoothly from -1 (back-driving, indices _b)
/// to 1 (motoring, _m). v0 smooths the sign of v, see coulomb_viscous.
class LoadDependent : public Stateless {
 public:
  enum Index { kFc, kMuM, kMuB, kNuM, kNuB, kFv, kV0, kL0, kSize };

  static constexpr std::string_view kName = "load_dependent";
  static constexpr std::string_view kEquation =
      "tau = (Fc + mu(d) |load| + nu(d) load^2) tanh(v/v0) + Fv v, d = direction of power flow";
  static constexpr std::string_view kSource =
      "Bittencourt & Gunnarsson, J. Dyn. Syst. Meas. Control 134, 2012; models M3-M6 of Duclusaud "
      "et "
      "al., ICRA 2025";
  static constexpr PlotLook kLook{"#882255", 4};
  static constexpr Claims kClaims{};
  static constexpr Reads kReads{.load = true};
  static constexpr int kMostElements = 0;

  static constexpr std::span<const ParameterInfo> parameters() { return kParameters; }

  template <class S>
  S torque(const S* theta, const Input<S>& in, const S*) const {
    const Terms<S> x = terms(theta, in);
    return level(theta, x) * x.t + theta[kFv] * in.v;
  }

  template <class S>
  void torque_pullback(const S* theta, const Input<S>& in, const S*, const S& tau_bar, S* theta_bar,
                       Input<S>& in_bar, S*) const {
    const Terms<S> x = terms(theta, in);
    const S motoring = S(0.5) * (S(1) + x.d), braking = S(0.5) * (S(1) - x.d);
    const S F_bar = tau_bar * x.t;
    const S L2 = x.L * x.L;
    theta_bar[kFc] += F_bar;
    theta_bar[kMuM] += F_bar * x.L * motoring;
    theta_bar[kMuB] += F_bar * x.L * braking;
    theta_bar[kNuM] += F_bar * L2 * motoring;
    theta_bar[kNuB] += F_bar * L2 * braking;
    theta_bar[kFv] += tau_bar * in.v;

    const S d_bar =
        F_bar * S(0.5) * ((theta[kMuM] - theta[kMuB]) * x.L + (theta[kNuM] - theta[kNuB]) * L2);
    const S L_bar = F_bar * (x.mu + S(2) * x.nu * x.L);
    const S t_bar = tau_bar * level(theta, x) + d_bar * x.u;
    const S u_bar = d_bar * x.t;

    // R = sqrt(load^2 + l0^2), L = R - l0, u = load / R
    const S R_bar = L_bar - u_bar * x.u / x.R;
    in_bar.load += u_bar / x.R + R_bar * x.u;
    theta_bar[kL0] += R_bar * theta[kL0] / x.R - L_bar;

    const S r_bar = t_bar * (S(1) - x.t * x.t);
    theta_bar[kV0] -= r_bar * in.v / (theta[kV0] * theta[kV0]);
    in_bar.v += r_bar / theta[kV0] + tau_bar * theta[kFv];
  }

  template <class S>
  S steady_torque(const S* theta, const Input<S>& in) const {
    return torque<S>(theta, in, nullptr);
  }

 private:
  template <class S>
  struct Terms {
    S t, R, L, u, d, mu, nu;
  };

  template <class S>
  static Terms<S> terms(const S* theta, const Input<S>& in) {
    Terms<S> x;
    x.t = tanh(in.v / theta[kV0]);
    x.R = sqrt(in.load * in.load + theta[kL0] * theta[kL0]);
    x.L = x.R - theta[kL0];
    x.u = in.load / x.R;
    x.d = x.t * x.u;
    const S motoring = S(0.5) * (S(1) + x.d), braking = S(0.5) * (S(1) - x.d);
    x.mu = theta[kMuM] * motoring + theta[kMuB] * braking;
    x.nu = theta[kNuM] * motoring + theta[kNuB] * braking;
    return x;
  }

  template <class S>
  static S level(const S* theta, const Terms<S>& x) {
    return theta[kFc] + (x.mu + x.nu * x.L) * x.L;
  }

  static constexpr std::array<ParameterInfo, kSize> kParameters{{
      {"Fc", "N m", Role::kCoulomb, 1e-6, 1e6, 5, Scale::kLog, "Coulomb friction without load"},
      {"mu_m", "1", Role::kLoadCoefficient, 0, 1, 0.05, Scale::kLinear,
       "load coefficient, motoring"},
      {"mu_b", "1", Role::kLoadCoefficient, 0, 1, 0.04, Scale::kLinear,
       "load coefficient, back-driving"},
      {"nu_m", "1/(N m)", Role::kLoadGrowth, 0, 0.1, 1e-4, Scale::kLinear,
       "quadratic load coefficient, motoring"},
      {"nu_b", "1/(N m)", Role::kLoadGrowth, 0, 0.1, 5e-5, Scale::kLinear,
       "quadratic load coefficient, back-driving"},
      {"Fv", "N m s/rad", Role::kViscous, 0, 1e6, 2.5, Scale::kLinear, "viscous coefficient"},
      {"v0", "rad/s", Role::kSmoothingSpeed, 1e-5, 1, 0.01, Scale::kLog, "smoothing speed"},
      {"l0", "N m", Role::kLoadSmoothing, 1e-4, 100, 0.1, Scale::kLog, "smoothing width of |load|"},
  }};
};

}  // namespace fricid::friction
