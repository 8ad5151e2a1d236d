// A bristle that is dragged along and relaxes at a rate r held over the step; shared by Dahl's law
// and LuGre.
#pragma once

#include <array>

#include "fricid/base/math.hpp"

namespace fricid::friction {

/// Derivative of phi1(x) = (e^x - 1) / x. Relative error < 1e-14 for x <= 0.
template <class S>
S phi1_derivative(S x) {
  // Taylor series sum_n n x^(n-1) / (n+1)! where the quotient (e^x - phi1) / x would cancel
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
  const S x_far = select(near, S(1), x);
  return select(near, series, (exp(x_far) - phi1(x_far)) / x_far);
}

/// Exact solution after dt [s] of
///
///     dz/dt = v - r z,    v [rad/s] and r >= 0 [1/s] held.
///
/// Bounded by max(|z|, |v|/r) at any dt; dt = 0 or v = r = 0 return z.
template <class S>
S bristle_step(const S& v, const S& r, double dt, const S& z) {
  return z + S(dt) * (v - r * z) * phi1(-r * S(dt));
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
  const S x = -r * h;
  const S p = phi1(x);
  return {z_next_bar * h * p, -z_next_bar * h * (z * p + h * (v - r * z) * phi1_derivative(x)),
          z_next_bar * exp(x)};
}

}  // namespace fricid::friction
