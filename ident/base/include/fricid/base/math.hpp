// Elementary functions as polynomials on any scalar type of the engine, so that lane k of a pack
// and a plain double give the same bits, vectorised under strict floating point. S is double,
// float, Pack<double, N> or Pack<float, N>. Call them unqualified from inside namespace fricid.
#pragma once

#include "fricid/base/detail/math_lanes.hpp"
#include "fricid/base/pack.hpp"

namespace fricid {

/// sin and cos of the same angle [rad].
template <class S>
struct SinCos {
  S sin, cos;
};

/// e^x.
template <Lanewise S>
[[gnu::flatten]] S exp(S x) {
  using R = detail::RealOf<S>;
  const S clamped =
      select(x > S(R::kExpHigh), S(R::kExpHigh), select(x < S(R::kExpLow), S(R::kExpLow), x));
  const auto e = detail::exp_parts(clamped);
  return (S(1) + e.p) * e.low * e.high;
}

/// e^x - 1 without cancellation near x = 0.
template <Lanewise S>
[[gnu::flatten]] S expm1(S x) {
  using R = detail::RealOf<S>;
  const S clamped =
      select(x > S(R::kExpHigh), S(R::kExpHigh), select(x < S(R::kExpm1Low), S(R::kExpm1Low), x));
  const auto e = detail::exp_parts(clamped);
  // 2^n (p + 1 - 2^-n); 2^-n is exact or negligible
  const S inverse = select(e.n > S(64), S(0), S(1) / (e.low * e.high));
  return select(x == S(0), x, (e.p + (S(1) - inverse)) * e.low * e.high);
}

/// Natural logarithm; -inf at 0, NaN below.
template <Lanewise S>
[[gnu::flatten]] S log(S x) {
  using R = detail::RealOf<S>;
  constexpr int kShift = R::kMantissa + 2;
  const auto tiny = x < S(R::kSmallestNormal);
  const S scale = detail::power_of_two<S>(detail::Words<S>(kShift));
  const auto e = detail::log_parts(select(tiny, x * scale, x));
  const S n = select(tiny, e.n - S(kShift), e.n);
  const S y = detail::log_sum(e.m - S(1), n, S(0));
  const S edge = select(x == S(0), S(-R::kInf), select(x < S(0), S(R::kNaN), x));
  return select((x > S(0)) & (x < S(R::kInf)), y, edge);
}

/// log(1 + x) without cancellation near x = 0; -inf at -1, NaN below.
template <Lanewise S>
[[gnu::flatten]] S log1p(S x) {
  using R = detail::RealOf<S>;
  const S u = S(1) + x;
  const auto e = detail::log_parts(u);
  // what rounding u has lost, divided by u
  const S lost = select(x > S(1), S(1) - (u - x), x - (u - S(1))) / u;
  const auto near_one = e.n == S(0);
  const S y = detail::log_sum(select(near_one, x, e.m - S(1)), e.n, select(near_one, S(0), lost));
  const S edge = select(x == S(-1), S(-R::kInf), select(x < S(-1), S(R::kNaN), x));
  return select((x > S(-1)) & (x < S(R::kInf)) & (x != S(0)), y, edge);
}

/// sin and cos of x [rad].
template <Lanewise S>
[[gnu::flatten]] SinCos<S> sincos(S x) {
  using R = detail::RealOf<S>;
  const auto n = detail::round_to_integer(x * S(R::kTwoOverPi));
  S r = fma(-n.real, S(R::kHalfPi[0]), x);
  r = fma(-n.real, S(R::kHalfPi[1]), r);
  r = fma(-n.real, S(R::kHalfPi[2]), r);
  const S z = r * r;
  const S s = fma(r * z, detail::polynomial(z, R::kSin), r);
  const S c = fma(z, fma(z, detail::polynomial(z, R::kCos), S(-0.5)), S(1));

  // quadrant n mod 4: odd swaps, bit 1 changes the sign of sin, bit 1 of n + 1 that of cos
  using Word = typename R::Word;
  constexpr int kTop = R::kMantissa == 52 ? 62 : 30;
  const auto sign_s = (n.integer << kTop) & R::kSign;
  const auto sign_c = ((n.integer + Word(1)) << kTop) & R::kSign;
  const auto odd = from_bits((n.integer & Word(1)) * R::kBias << R::kMantissa) == S(1);
  SinCos<S> y{from_bits(to_bits(select(odd, c, s)) ^ sign_s),
              from_bits(to_bits(select(odd, s, c)) ^ sign_c)};
  y.sin = select(x == S(0), x, y.sin);
  const auto large = abs(x) > S(R::kTrigLimit);
  if (any(large)) {
    for (int i = 0; i < kLaneCount<S>; ++i) {
      if (abs(lane(x, i)) <= R::kTrigLimit) continue;
      set_lane(y.sin, i, std::sin(lane(x, i)));
      set_lane(y.cos, i, std::cos(lane(x, i)));
    }
  }
  return y;
}

/// Hyperbolic tangent.
template <Lanewise S>
[[gnu::flatten]] S tanh(S x) {
  const S e = expm1(S(-2) * abs(x));
  const S magnitude = -e / (S(2) + e);
  return select(x == S(0), x, select(x < S(0), -magnitude, magnitude));
}

/// log(1 + e^x).
template <Lanewise S>
[[gnu::flatten]] S softplus(S x) {
  return max(x, S(0)) + log1p(exp(-abs(x)));
}

/// x tanh(softplus(x)) = x (e^2 + 2 e) / (e^2 + 2 e + 2), e = exp x.
template <Lanewise S>
[[gnu::flatten]] S mish(S x) {
  const S low = S(detail::RealOf<S>::kExpLow);
  const S e = exp(min(x, S(24)));
  const S numerator = e * (e + S(2));
  return select(x < low, low, x) * (numerator / (numerator + S(2)));
}

/// (e^x - 1) / x, 1 at x = 0.
template <Lanewise S>
[[gnu::flatten]] S phi1(S x) {
  const S y = expm1(x) / x;
  return select(x == S(0), S(1), select(x > S(detail::RealOf<S>::kExpHigh), x, y));
}

/// x^y for x >= 0; pow(0, y > 0) = 0, pow(x, 0) = 1.
template <Lanewise S>
[[gnu::flatten]] S pow(S x, S y) {
  return select(y == S(0), S(1), exp(y * log(x)));
}

}  // namespace fricid
