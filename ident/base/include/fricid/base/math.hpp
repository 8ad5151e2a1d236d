// Elementary functions as polynomials on any scalar type of the engine, so that lane k of a pack
// and a plain double give the same bits, vectorised under strict floating point. S is double,
// float, Pack<double, N> or Pack<float, N>. Call them unqualified from inside namespace fricid.
// Errors are the largest found by tests/base/math_accuracy_test.cpp, in units in the last place of
// the result. Unless said otherwise NaN gives NaN and the limits at infinities, zeros with sign and
// overflow are those of <cmath>.
#pragma once

#include "fricid/base/detail/math_lanes.hpp"
#include "fricid/base/pack.hpp"

namespace fricid {

/// e^x. Error <= 1 ulp.
template <Lanewise S>
[[gnu::flatten]] S exp(S x) {
  using R = detail::RealOf<S>;
  const auto e = detail::reduce_exponent(detail::clamp_range(x, R::kExpLow, R::kExpHigh));
  return detail::scale(detail::add_expm1(S(1), e.r), e.n);
}

/// e^-x for x >= 0 with small absolute, not relative, error: <= 2^-53 (float: 2^-24). Returns e^-60
/// for x > 60. Takes half the instructions of exp.
template <Lanewise S>
[[gnu::always_inline, gnu::flatten]] inline S decay(S x) {
  using R = detail::RealOf<S>;
  const S y = min(S(60), x);
  const S shifted = fma(y, S(-R::kLog2e), S(R::kRound));
  const S r = fma(shifted - S(R::kRound), S(-R::kLn2), -y);
  const S power = fma(r, fma(r, detail::polynomial(r, R::kExp), S(1)), S(1));
  return from_bits(to_bits(power) + (to_bits(shifted) << R::kMantissa));
}

/// e^x - 1 without cancellation near x = 0. Error <= 2 ulp.
template <Lanewise S>
[[gnu::flatten]] S expm1(S x) {
  const auto e = detail::expm1_parts(x);
  return select(x == S(0), x, detail::scale(e.y, e.n));
}

/// (e^x - 1) / x, 1 at x = 0. Error <= 3 ulp.
template <Lanewise S>
[[gnu::flatten]] S phi1(S x) {
  const auto e = detail::expm1_parts(x);
  const S divisor = min(S(detail::RealOf<S>::kExpHigh), x);
  return select(x == S(0), S(1), detail::scale(e.y / divisor, e.n));
}

/// Natural logarithm; -inf at 0, NaN below. Error <= 1 ulp.
template <Lanewise S>
[[gnu::flatten]] S log(S x) {
  const auto e = detail::log_parts_of_any(x);
  const S y = detail::log_sum(e.m - S(1), e.n, S(0));
  return select((x > S(0)) & (x < S(detail::RealOf<S>::kInf)), y, detail::log_edge(x));
}

/// log(1 + x) without cancellation near x = 0; -inf at -1, NaN below. Error <= 1 ulp.
template <Lanewise S>
[[gnu::flatten]] S log1p(S x) {
  using R = detail::RealOf<S>;
  const S u = S(1) + x;
  const auto e = detail::log_parts(u);
  const S f = e.m - S(1);
  // the rounding error of u, divided by u = 2^n (1 + f); 1 / (1 + f) needs an accuracy of 2 % only
  const S lost = select(x > S(1), S(1) - (u - x), x - (u - S(1)));
  const S scale =
      detail::power_of_two<S>(detail::Words<S>(0) - detail::round_to_integer(e.n).integer);
  const S tail =
      select(u < S(2 / R::kEpsilon), lost * scale * fma(f, fma(f, S(0.8), S(-1)), S(1)), S(0));
  const auto near_one = e.n == S(0);
  const S y = detail::log_sum(select(near_one, x, f), e.n, select(near_one, S(0), tail));
  return select((x > S(-1)) & (x < S(R::kInf)) & (x != S(0)), y,
                select(x == S(0), x, detail::log_edge(u)));
}

/// sin and cos of the same angle [rad].
template <class S>
struct SinCos {
  S sin, cos;
};

/// sin and cos of x [rad]. Error <= 2 ulp. Lanes beyond |x| = 2^30 (float: 2^17) go through
/// std::sin and std::cos one by one.
template <Lanewise S>
[[gnu::flatten]] SinCos<S> sincos(S x) {
  using R = detail::RealOf<S>;
  using Words = detail::Words<S>;
  // x = n pi/2 + r by Cody and Waite: the first product is exact in the fused step
  const auto n = detail::round_to_integer(x * S(R::kTwoOverPi));
  S r = fma(n.real, S(-R::kHalfPi[0]), x);
  r = fma(n.real, S(-R::kHalfPi[1]), r);
  r = fma(n.real, S(-R::kHalfPi[2]), r);
  const S z = r * r;
  const S s = fma(r * z, detail::polynomial(z, R::kSin), r);
  const S c = fma(z, fma(z, detail::polynomial(z, R::kCos), S(-0.5)), S(1));

  // Odd n swaps them; bit 1 of n is the sign of sin, bit 1 of n + 1 that of cos.
  const Words odd = n.integer & Words(1);
  const auto swap = detail::is_set(odd);
  const Words sign_sin = (n.integer << R::kSecondBitToSign) & Words(R::kSign);
  const Words sign_cos = ((n.integer + Words(1)) << R::kSecondBitToSign) & Words(R::kSign);
  SinCos<S> y{from_bits(to_bits(select(swap, c, s)) ^ sign_sin),
              from_bits(to_bits(select(swap, s, c)) ^ sign_cos)};
  y.sin = select(x == S(0), x, y.sin);

  if (any(abs(x) > S(R::kTrigLimit))) {
    for (int i = 0; i < kLaneCount<S>; ++i) {
      if (abs(lane(x, i)) <= R::kTrigLimit) continue;
      set_lane(y.sin, i, std::sin(lane(x, i)));
      set_lane(y.cos, i, std::cos(lane(x, i)));
    }
  }
  return y;
}

/// Hyperbolic tangent. Error <= 3 ulp.
template <Lanewise S>
[[gnu::flatten]] S tanh(S x) {
  const S e = expm1(S(-2) * abs(x));
  const S magnitude = -e / (S(2) + e);
  return select(x == S(0), x, select(x < S(0), -magnitude, magnitude));
}

/// log(1 + e^x). Error <= 2 ulp.
template <Lanewise S>
[[gnu::flatten]] S softplus(S x) {
  return max(S(0), x) + detail::log1p_of_share(exp(-abs(x)));
}

/// x tanh(softplus(x)) = x (e^2 + 2 e) / (e^2 + 2 e + 2) with e = exp x; -0 at -inf. Error <= 5 ulp
/// for x >= -708 (float: -87); below, absolute error <= 2e-320 (float: 1e-42).
/// @see Misra, "Mish: A self regularized non-monotonic activation function", BMVC 2020
template <Lanewise S>
[[gnu::flatten]] S mish(S x) {
  const S low = S(detail::RealOf<S>::kExpLow);
  const S e = exp(min(S(24), x));
  const S numerator = e * (e + S(2));
  return max(low, x) * (numerator / (numerator + S(2)));
}

/// x^y for x >= 0, NaN below; pow(0, y > 0) = 0, pow(x, 0) = pow(1, y) = 1.
/// Error <= 1 + |y log x| / 4 ulp, and <= 2 ulp for |y| <= 1.5.
template <Lanewise S>
[[gnu::flatten]] S pow(S x, std::type_identity_t<S> y) {
  using R = detail::RealOf<S>;
  const auto l = detail::log_extended(x);
  const S product = y * l.high;
  const S clamped = detail::clamp_range(product, R::kExpLow, R::kExpHigh);
  const S tail = select(clamped == product, fma(y, l.low, fma(y, l.high, -product)), S(0));
  const auto e = detail::reduce_exponent(clamped);
  const S power = detail::scale(detail::add_expm1(S(1), e.r + tail), e.n);
  return select((y == S(0)) | (x == S(1)), S(1), power);
}

}  // namespace fricid
