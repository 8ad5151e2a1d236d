// A bristle that is dragged along and relaxes at a rate r held over the step; shared by Dahl's law
// and LuGre.
#pragma once

#include <array>

#include "fricid/base/math.hpp"

namespace fricid::friction {

/// phi1(x) = (e^x - 1) / x with its derivative and e^x, from one call of expm1.
template <class S>
struct Phi1 {
  S value, derivative, exponential;
};

/// For x <= 0; relative error of the derivative < 1e-14.
template <class S>
Phi1<S> phi1_with_derivative(const S& x) {
  // Taylor series sum_n n x^(n-1) / (n+1)! of the derivative where (e^x - phi1) / x would cancel
  constexpr int kTerms = 15;
  constexpr auto kCoefficients = [] {
    std::array<double, kTerms> c{};
    double factorial = 1;
    for (int n = 1; n <= kTerms; ++n) {
      factorial *= n + 1;
      c[static_cast<std::size_t>(n - 1)] = n / factorial;
    }
    return c;
  }();
  const auto near = abs(x) < S(1);
  const S x_near = select(near, x, S(0));
  S series = S(kCoefficients.back());
  for (int n = kTerms - 2; n >= 0; --n)
    series = series * x_near + S(kCoefficients[static_cast<std::size_t>(n)]);

  const S rise = expm1(x);
  const auto tiny = abs(x) < S(1e-30);  // phi1 = 1, and 1/x may overflow
  const S inverse = S(1) / select(tiny, S(1), x);
  const S value = select(tiny, S(1), rise * inverse);
  return {value, select(near, series, (S(1) + rise - value) * inverse), S(1) + rise};
}

/// Exact solution after dt [s] of
///
///     dz/dt = v - r z,    v [rad/s] and r >= 0 [1/s] held.
///
/// Bounded by max(|z|, |v|/r) at any dt; dt = 0 or v = r = 0 return z.
template <class S>
[[gnu::always_inline]] inline S bristle_step(const S& v, const S& r, double dt, const S& z) {
  return z + S(dt) * (v - r * z) * phi1(-r * S(dt));
}

/// 1 - e^-|x|, and the same with the sign of x.
template <class S>
struct Saturation {
  S even, odd;
};
template <class S>
[[gnu::always_inline]] inline Saturation<S> saturation(const S& x) {
  const S even = S(1) - decay(abs(x));
  return {even, even * sign(x)};
}

/// bristle_step in terms of the deflection at which the bristle settles, level = |v|/r, and the
/// travel in units of it, x = v dt/level: without a division.
template <class S>
[[gnu::always_inline]] inline S bristle_settle(const S& level, const S& x, const S& z) {
  const auto share = saturation(x);
  return z + (level * share.odd - z * share.even);
}

/// Vector-Jacobian product of bristle_step.
template <class S>
struct BristleBar {
  S v, r, z;
};
template <class S>
BristleBar<S> bristle_step_pullback(const S& v, const S& r, double dt, const S& z,
                                    const S& z_next_bar) {
  const S h = S(dt);
  const Phi1<S> p = phi1_with_derivative(-r * h);
  return {z_next_bar * h * p.value,
          -z_next_bar * h * (z * p.value + h * (v - r * z) * p.derivative),
          z_next_bar * p.exponential};
}

}  // namespace fricid::friction
