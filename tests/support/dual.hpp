// Forward-mode dual numbers: exact derivatives of any template of the engine, one direction at a
// time.
#pragma once

#include <cmath>

namespace fricid::test {

/// x + d epsilon with epsilon^2 = 0. Comparisons look at x, so a branch is differentiated as taken.
struct Dual {
  double x = 0, d = 0;

  Dual() = default;
  Dual(double value, double derivative = 0) : x(value), d(derivative) {}

  friend Dual operator+(Dual a, Dual b) { return {a.x + b.x, a.d + b.d}; }
  friend Dual operator-(Dual a, Dual b) { return {a.x - b.x, a.d - b.d}; }
  friend Dual operator*(Dual a, Dual b) { return {a.x * b.x, a.d * b.x + a.x * b.d}; }
  friend Dual operator/(Dual a, Dual b) { return {a.x / b.x, (a.d - a.x / b.x * b.d) / b.x}; }
  friend Dual operator-(Dual a) { return {-a.x, -a.d}; }
  Dual& operator+=(Dual b) { return *this = *this + b; }
  Dual& operator-=(Dual b) { return *this = *this - b; }
  Dual& operator*=(Dual b) { return *this = *this * b; }
  Dual& operator/=(Dual b) { return *this = *this / b; }

  friend bool operator<(Dual a, Dual b) { return a.x < b.x; }
  friend bool operator<=(Dual a, Dual b) { return a.x <= b.x; }
  friend bool operator>(Dual a, Dual b) { return a.x > b.x; }
  friend bool operator>=(Dual a, Dual b) { return a.x >= b.x; }
  friend bool operator==(Dual a, Dual b) { return a.x == b.x; }
  friend bool operator!=(Dual a, Dual b) { return a.x != b.x; }
};

inline Dual exp(Dual a) { return {std::exp(a.x), std::exp(a.x) * a.d}; }
inline Dual decay(Dual a) { return exp(-a); }
struct DualSaturation {
  Dual even, odd;
};
/// The odd one is smooth at 0, which a product with the sign would hide.
inline DualSaturation saturation(Dual a) {
  const double even = -std::expm1(-std::abs(a.x)), slope = 1 - even;
  const double sign = a.x > 0 ? 1 : a.x < 0 ? -1 : 0;
  return {{even, sign * slope * a.d}, {sign * even, slope * a.d}};
}
inline Dual log(Dual a) { return {std::log(a.x), a.d / a.x}; }
inline Dual log1p(Dual a) { return {std::log1p(a.x), a.d / (1 + a.x)}; }
inline Dual expm1(Dual a) { return {std::expm1(a.x), std::exp(a.x) * a.d}; }
inline Dual sqrt(Dual a) { return {std::sqrt(a.x), a.d / (2 * std::sqrt(a.x))}; }
inline Dual abs(Dual a) { return a.x < 0 ? -a : a.x > 0 ? a : Dual(0); }
inline Dual pow(Dual a, Dual b) {
  const double y = std::pow(a.x, b.x);
  return {y, y * (b.d * std::log(a.x) + b.x * a.d / a.x)};
}
inline Dual tanh(Dual a) {
  const double t = std::tanh(a.x);
  const double c = std::cosh(a.x);
  return {t, a.d / (c * c)};
}
inline Dual fma(Dual a, Dual b, Dual c) { return a * b + c; }
/// x tanh(log(1 + e^x))
inline Dual mish(Dual a) { return a * tanh(log1p(exp(a))); }

struct DualSinCos {
  Dual sin, cos;
};
inline DualSinCos sincos(Dual a) {
  const double s = std::sin(a.x), c = std::cos(a.x);
  return {{s, c * a.d}, {c, -s * a.d}};
}

/// (e^x - 1) / x; its derivative by the Taylor series near 0, by the quotient elsewhere.
inline Dual phi1(Dual a) {
  if (a.x == 0) return {1, a.d / 2};
  const double y = std::expm1(a.x) / a.x;
  if (std::abs(a.x) > 0.5) return {y, (std::exp(a.x) - y) / a.x * a.d};
  double slope = 0, power = 1, factorial = 1;
  for (int n = 1; n <= 16; ++n) {
    factorial *= n + 1;
    slope += n * power / factorial;
    power *= a.x;
  }
  return {y, slope * a.d};
}

}  // namespace fricid::test
