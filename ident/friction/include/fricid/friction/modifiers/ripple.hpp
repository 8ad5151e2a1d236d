#pragma once

#include <array>
#include <span>
#include <string_view>

#include "fricid/base/math.hpp"
#include "fricid/friction/elements.hpp"
#include "fricid/friction/law.hpp"

namespace fricid::friction {

/// Friction that varies with the angle of the gear:
///
///     tau' = (1 + sum_k A_k sin(n_k q + phi_k)) tau,    k = 1 .. order
///
/// n_k counts periods per 2 pi of joint angle: a strain-wave gear of ratio i ripples at 2 i. At
/// most kMostElements terms, and their bounds keep the factor positive.
class Ripple {
 public:
  static constexpr std::string_view kName = "ripple";
  static constexpr std::string_view kEquation = "tau' = (1 + sum_k A_k sin(n_k q + phi_k)) tau";
  static constexpr std::string_view kSource =
      "Armstrong, ICRA 1988; Tuttle & Seering, IEEE TRA 12(3), 1996";
  static constexpr Claims kClaims{};
  static constexpr Reads kReads{.q = true};
  static constexpr int kMostElements = 4;

  /// @param order number of terms, 1 .. kMostElements
  explicit constexpr Ripple(int order) : order_(order) {}

  static constexpr int state_size() { return 0; }
  constexpr std::span<const ParameterInfo> parameters() const {
    return std::span(kParameters).first(static_cast<std::size_t>(3 * order_));
  }
  /// Indices in theta.
  static constexpr int n(int k) { return 3 * k; }
  static constexpr int A(int k) { return 3 * k + 1; }
  static constexpr int phi(int k) { return 3 * k + 2; }

  template <class S>
  S apply(const S* theta, const Input<S>& in, const S& tau) const {
    return factor(theta, in.q) * tau;
  }

  template <class S>
  void apply_pullback(const S* theta, const Input<S>& in, const S& tau, const S& out_bar,
                      S* theta_bar, Input<S>& in_bar, S& tau_bar) const {
    const S factor_bar = out_bar * tau;
    S value = S(1);
    for (int k = 0; k < order_; ++k) {
      const auto wave = sincos(theta[n(k)] * in.q + theta[phi(k)]);
      value += theta[A(k)] * wave.sin;
      const S angle_bar = factor_bar * theta[A(k)] * wave.cos;
      theta_bar[A(k)] += factor_bar * wave.sin;
      theta_bar[n(k)] += angle_bar * in.q;
      theta_bar[phi(k)] += angle_bar;
      in_bar.q += angle_bar * theta[n(k)];
    }
    tau_bar += out_bar * value;
  }

 private:
  template <class S>
  S factor(const S* theta, const S& q) const {
    S value = S(1);
    for (int k = 0; k < order_; ++k)
      value += theta[A(k)] * sincos(theta[n(k)] * q + theta[phi(k)]).sin;
    return value;
  }

  // typical: twice, once and four times per turn of the motor of a gear 1:100
  static constexpr std::array<ParameterInfo, 3 * kMostElements> kParameters = [] {
    constexpr double kTypicalOrder[kMostElements] = {200, 100, 400, 50};
    constexpr double kPi = 3.14159265358979323846;
    std::array<ParameterInfo, 3 * kMostElements> p{};
    for (int k = 0; k < kMostElements; ++k) {
      ParameterInfo* term = &p[static_cast<std::size_t>(3 * k)];
      term[0] = {numbered<"n">(k),
                 "1/rad",
                 Role::kWaveNumber,
                 0.1,
                 2000,
                 kTypicalOrder[k],
                 Scale::kLinear,
                 "periods per 2 pi of joint angle",
                 k + 1};
      term[1] = {numbered<"A">(k),
                 "1",
                 Role::kAmplitude,
                 0,
                 0.24,
                 k == 0 ? 0.03 : 0.01,
                 Scale::kLinear,
                 "relative amplitude",
                 k + 1};
      term[2] = {numbered<"phi">(k), "rad",   Role::kPhase, -kPi, kPi, 0,
                 Scale::kLinear,     "phase", k + 1};
    }
    return p;
  }();

  int order_;
};

}  // namespace fricid::friction
