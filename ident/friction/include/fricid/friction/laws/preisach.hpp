#pragma once

#include <array>
#include <span>
#include <string_view>

#include "fricid/base/math.hpp"
#include "fricid/friction/elements.hpp"
#include "fricid/friction/law.hpp"

namespace fricid::friction {

/// Preisach operator of the deflection of a contact that yields as a whole at +-L:
///
///     z_i' = clamp(z_i + v dt, -r_i, r_i),   r_i = L i/N,   u = z_N,   xi_i = u - z_i
///     tau  = Fc sum_i a_i (psi(u) - psi(xi_i)) / (psi(L) - psi(L - r_i)),   a_i = alpha_i / sum
///     alpha psi(s) = s + beta s^3/L^2
///
/// Element i is a spring whose stiffness psi' depends on where it is deflected, on a slider xi_i
/// that follows u at the distance r_i (play): the Preisach density of the plane (r, s) lies on the
/// lines r = r_i with weight psi'(s). Where beta > 0 the major loop is soft in the middle and stiff
/// at its ends, as the torsion of strain-wave gears is; a branch after a reversal is no scaled
/// virgin curve, and minor loops of one size differ along the major one. With beta = 0 it is
/// maxwell_slip (a Prandtl-Ishlinskii operator). `step` is exact for any motion of one sign.
/// Friction takes energy: tau v - dU/dt = sum w_i psi'(xi_i) r_i |dxi_i/dt| >= 0 inside, tau v at
/// |u| = L. Only ratios of alpha count. State: z_1 .. z_N [rad].
class Preisach {
 public:
  enum Index { kFc, kLength, kBeta, kCommon };

  static constexpr std::string_view kName = "preisach";
  static constexpr std::string_view kEquation =
      "z_i' = clamp(z_i + v dt, +-L i/N); u = z_N; tau = Fc sum alpha_i/sum alpha "
      "(psi(u) - psi(u - z_i))/(psi(L) - psi(L - L i/N)); psi(s) = s + beta s^3/L^2";
  static constexpr std::string_view kSource =
      "Preisach operators by play operators: Brokate & Sprekels, Hysteresis and Phase Transitions, "
      "Springer 1996, ch. 2; soft windup of strain-wave gears: Taghirad & Belanger, J. Dyn. Syst. "
      "Meas. Control 120, 1998";
  static constexpr PlotLook kLook{"#6A3D9A", 13};
  static constexpr Claims kClaims{};
  static constexpr Reads kReads{};
  static constexpr int kMostElements = kMaxElements;
  static constexpr std::string_view kStateUnit = "rad";

  /// @param elements N, 1 .. kMaxElements
  explicit constexpr Preisach(int elements) : n_(elements) {}

  constexpr int state_size() const { return n_; }
  constexpr std::span<const ParameterInfo> parameters() const {
    return std::span(kTables[static_cast<std::size_t>(n_)])
        .first(static_cast<std::size_t>(kCommon + n_));
  }
  /// Index in theta, after the common ones.
  static constexpr int alpha(int i) { return kCommon + i; }

  template <class S>
  S torque(const S* theta, const Input<S>&, const S* z) const {
    const S beta = theta[kBeta], u = deflection(z) / theta[kLength];
    S sum = S(0), alpha_sum = S(0);
    for (int i = 0; i < n_; ++i) {
      const S x = u - z[i] / theta[kLength];
      sum += theta[alpha(i)] * (psi(beta, u) - psi(beta, x)) / full(beta, i);
      alpha_sum += theta[alpha(i)];
    }
    return theta[kFc] * sum / alpha_sum;
  }

  template <class S>
  void step(const S* theta, const Input<S>& in, double dt, S* z) const {
    for (int i = 0; i < n_; ++i) {
      const S r = share(i) * theta[kLength];
      z[i] = clamp(z[i] + in.v * S(dt), -r, r);
    }
  }

  template <class S>
  void torque_pullback(const S* theta, const Input<S>&, const S* z, const S& tau_bar, S* theta_bar,
                       Input<S>&, S* z_bar) const {
    const S beta = theta[kBeta], L = theta[kLength], u = deflection(z) / L;
    S sum = S(0), alpha_sum = S(0);
    for (int i = 0; i < n_; ++i) {
      sum += theta[alpha(i)] * (psi(beta, u) - psi(beta, u - z[i] / L)) / full(beta, i);
      alpha_sum += theta[alpha(i)];
    }
    theta_bar[kFc] += tau_bar * sum / alpha_sum;
    const S sum_bar = tau_bar * theta[kFc] / alpha_sum;
    for (int i = 0; i < n_; ++i) {
      const S x = u - z[i] / L, all = full(beta, i);
      const S part = (psi(beta, u) - psi(beta, x)) / all;
      theta_bar[alpha(i)] += sum_bar * (part - sum / alpha_sum);
      const S rise_bar = sum_bar * theta[alpha(i)] / all;  // of psi(u) - psi(x)
      const S low = S(1 - share(i));
      theta_bar[kBeta] += rise_bar * (u * u * u - x * x * x - part * (S(1) - low * low * low));
      const S u_bar = rise_bar * slope(beta, u), x_bar = -rise_bar * slope(beta, x);
      z_bar[n_ - 1] += (u_bar + x_bar) / L;
      z_bar[i] -= x_bar / L;
      theta_bar[kLength] -= (u_bar * u + x_bar * x) / L;
    }
  }

  template <class S>
  void step_pullback(const S* theta, const Input<S>& in, double dt, const S* z, const S* z_next_bar,
                     S* theta_bar, Input<S>& in_bar, S* z_bar) const {
    for (int i = 0; i < n_; ++i) {
      const S free = z[i] + in.v * S(dt);
      const S sticks_bar = select(abs(free) < share(i) * theta[kLength], z_next_bar[i], S(0));
      z_bar[i] += sticks_bar;
      in_bar.v += sticks_bar * S(dt);
      theta_bar[kLength] += (z_next_bar[i] - sticks_bar) * share(i) * sign(free);
    }
  }

  /// v = 0 returns 0.
  template <class S>
  S steady_torque(const S* theta, const Input<S>& in) const {
    return theta[kFc] * sign(in.v);
  }

  void state_bound(const double* theta, double, double* bound) const {
    for (int i = 0; i < n_; ++i) bound[i] = share(i) * theta[kLength];
  }

 private:
  /// r_i / L.
  constexpr double share(int i) const { return static_cast<double>(i + 1) / n_; }
  /// u: the state of the last element.
  template <class S>
  S deflection(const S* z) const {
    S u = S(0);
    for (int i = 0; i < n_; ++i) u = z[i];
    return u;
  }
  /// psi of s = x L, over L.
  template <class S>
  static S psi(const S& beta, const S& x) {
    return x + beta * x * x * x;
  }
  template <class S>
  static S slope(const S& beta, const S& x) {
    return S(1) + S(3) * beta * x * x;
  }
  /// (psi(L) - psi(L - r_i)) / L.
  template <class S>
  S full(const S& beta, int i) const {
    return psi(beta, S(1)) - psi(beta, S(1 - share(i)));
  }

  static constexpr auto kTables = [] {
    std::array<std::array<ParameterInfo, kCommon + kMaxElements>, kMaxElements + 1> tables{};
    for (int n = 1; n <= kMaxElements; ++n) {
      auto& table = tables[static_cast<std::size_t>(n)];
      table[kFc] = {"Fc", "N m", Role::kCoulomb, 1e-6, 1e6, 5, Scale::kLog, "Coulomb friction"};
      table[kLength] = {
          "L", "rad", Role::kLength, 1e-6,
          1,   4e-3,  Scale::kLog,   "deflection at which the contact yields as a whole"};
      table[kBeta] = {
          "beta", "1", Role::kStiffening, 0,
          100,    1,   Scale::kLinear,    "growth of the stiffness with the deflection"};
      for (int i = 0; i < n; ++i)
        table[static_cast<std::size_t>(kCommon + i)] = {
            numbered<"alpha">(i),
            "1",
            Role::kShare,
            1e-6,
            1e3,
            1.0 / n,
            Scale::kLog,
            "share of the element, relative to the sum of all",
            i + 1};
    }
    return tables;
  }();

  int n_;
};

}  // namespace fricid::friction
