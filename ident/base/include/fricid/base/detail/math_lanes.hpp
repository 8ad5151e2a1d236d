// Bit patterns, constants and range reductions behind math.hpp.
#pragma once

#include <bit>
#include <concepts>
#include <cstdint>

#include "fricid/base/pack.hpp"

namespace fricid {

/// The scalar types that math.hpp is written for.
template <class S>
concept Lanewise =
    std::same_as<decltype(lane(S(), 0)), double> || std::same_as<decltype(lane(S(), 0)), float>;

namespace detail {

/// Unsigned integers lane for lane as wide as S.
template <class S>
using Words = decltype(to_bits(S()));

/// IEEE 754 layout and rounded constants of one scalar type. `kRound` = 1.5 2^mantissa: adding it
/// leaves the nearest integer in the low mantissa bits.
template <class T>
struct Real;

template <>
struct Real<double> {
  using Word = std::uint64_t;
  static constexpr int kMantissa = 52;
  static constexpr Word kBias = 1023;
  static constexpr Word kSign = Word{1} << 63;
  static constexpr Word kMantissaMask = (Word{1} << 52) - 1;
  static constexpr double kInf = __builtin_inf();
  static constexpr double kNaN = __builtin_nan("");
  static constexpr int kSecondBitToSign = 62;
  static constexpr double kEpsilon = 0x1p-52;
  static constexpr double kSmallestNormal = 0x1p-1022;
  static constexpr double kRound = 0x1.8p52;
  static constexpr double kSqrtHalf = 0x1.6a09e667f3bcdp-1;

  // exp: overflow above, zero below; -1 from expm1 below
  static constexpr double kVanishes = -1077;  // 4 2^n is rounded to 0 for n below
  static constexpr double kExpHigh = 720, kExpLow = -760, kExpm1Low = -50;
  static constexpr double kLog2e = 0x1.71547652b82fep+0;
  static constexpr double kLn2 = 0x1.62e42fefa39efp-1;
  static constexpr double kLn2High = 0x1.62e42fefa4000p-1, kLn2Low = -0x1.8432a1b0e2634p-43;
  static constexpr double kTwoOverPi = 0x1.45f306dc9c883p-1;
  static constexpr double kHalfPi[3] = {0x1.921fb54442d18p+0, 0x1.1a62633145c07p-54,
                                        -0x1.f1976b7ed8fbcp-110};
  static constexpr double kTrigLimit = 0x1p30;

  // (e^r - 1 - r) / r^2 on |r| <= ln(2)/2: relative error of r + r^2 p(r) below 2^-60
  static constexpr double kExp[] = {0.5,
                                    0x1.5555555555557p-3,
                                    0x1.5555555555556p-5,
                                    0x1.111111111009cp-7,
                                    0x1.6c16c16c162b0p-10,
                                    0x1.a01a01ac0a9eep-13,
                                    0x1.a01a01a6ec522p-16,
                                    0x1.71de01c3fc936p-19,
                                    0x1.27e4db25ce3adp-22,
                                    0x1.af4ecd2129492p-26,
                                    0x1.1f7385560be05p-29};
  // (log((1 + s) / (1 - s)) - 2 s) / s^3 in z = s^2, m in [sqrt(1/2), sqrt(2)]: 2^-55.7
  static constexpr double kLog[] = {
      0x1.55555555557b0p-1, 0x1.99999998cb356p-2, 0x1.249249e06c9dap-2, 0x1.c71bd302523a6p-3,
      0x1.747fe2480d97fp-3, 0x1.3717c51a087d2p-3, 0x1.482443db8126ap-3};
  // the same for z in [0, 1/9], the logarithm of 1 to 2: 2^-57
  static constexpr double kLogWide[] = {
      0x1.5555555555555p-1, 0x1.999999999a3dfp-2, 0x1.24924923d422cp-2, 0x1.c71c727164156p-3,
      0x1.745cf0aa6a011p-3, 0x1.3b18b34a260a3p-3, 0x1.10ac6a3d3e5f6p-3, 0x1.eb913ba3ef69ep-4,
      0x1.687604d0c86a1p-4, 0x1.4b0ed4be611b2p-3};
  // (sin r - r) / r^3 and (cos r - 1 + r^2/2) / r^4 in z = r^2, |r| <= 1.02 pi/4: 2^-55.3, 2^-58.6
  static constexpr double kSin[] = {-0x1.5555555555527p-3,  0x1.111111110c6b0p-7,
                                    -0x1.a01a01962b5d1p-13, 0x1.71de30a260f5ap-19,
                                    -0x1.ae5ad3c86e6c5p-26, 0x1.5c98bc04789b0p-33};
  static constexpr double kCos[] = {0x1.55555555554f1p-5,  -0x1.6c16c16c08ff5p-10,
                                    0x1.a01a018a89685p-16, -0x1.27e4eb968a890p-22,
                                    0x1.1ee1ef7c07b94p-29, -0x1.8bca78a861b01p-37};
};

template <>
struct Real<float> {
  using Word = std::uint32_t;
  static constexpr int kMantissa = 23;
  static constexpr Word kBias = 127;
  static constexpr Word kSign = Word{1} << 31;
  static constexpr Word kMantissaMask = (Word{1} << 23) - 1;
  static constexpr float kInf = __builtin_inff();
  static constexpr float kNaN = __builtin_nanf("");
  static constexpr int kSecondBitToSign = 30;
  static constexpr float kEpsilon = 0x1p-23f;
  static constexpr float kSmallestNormal = 0x1p-126f;
  static constexpr float kRound = 0x1.8p23f;
  static constexpr float kSqrtHalf = 0x1.6a09e6p-1f;

  static constexpr float kVanishes = -152;
  static constexpr float kExpHigh = 100, kExpLow = -110, kExpm1Low = -25;
  static constexpr float kLog2e = 0x1.715476p+0f;
  static constexpr float kLn2 = 0x1.62e430p-1f;
  static constexpr float kLn2High = 0x1.62e400p-1f, kLn2Low = 0x1.7f7d1cp-20f;
  static constexpr float kTwoOverPi = 0x1.45f306p-1f;
  static constexpr float kHalfPi[3] = {0x1.921fb6p+0f, -0x1.777a5cp-25f, -0x1.ee59dap-50f};
  static constexpr float kTrigLimit = 0x1p17f;

  // as above; relative errors 2^-29, 2^-31, 2^-30, 2^-28, 2^-30
  static constexpr float kExp[] = {0.5f,           0x1.555556p-3f,  0x1.5554e8p-5f,
                                   0x1.1110e0p-7f, 0x1.6d444ap-10f, 0x1.a125f6p-13f};
  static constexpr float kLog[] = {0x1.555554p-1f, 0x1.999a7ap-2f, 0x1.2438f4p-2f, 0x1.e2f576p-3f};
  static constexpr float kLogWide[] = {0x1.555556p-1f, 0x1.9998d4p-2f, 0x1.24c92cp-2f,
                                       0x1.bc8c5ep-3f, 0x1.dba57ap-3f};
  static constexpr float kSin[] = {-0x1.555556p-3f, 0x1.111108p-7f, -0x1.a00eb2p-13f,
                                   0x1.6ca0f0p-19f};
  static constexpr float kCos[] = {0x1.555548p-5f, -0x1.6c0b70p-10f, 0x1.99b234p-16f};
};

template <class S>
using RealOf = Real<decltype(lane(S(), 0))>;

/// c[0] + c[1] x + c[2] x^2 + ..., even and odd powers apart: half the latency of Horner's scheme.
template <Lanewise S, class T, int n>
S polynomial(S x, const T (&c)[n]) {
  static_assert(n >= 2);
  constexpr int kEven = (n - 1) / 2 * 2, kOdd = n / 2 * 2 - 1;
  const S square = x * x;
  S even(c[kEven]), odd(c[kOdd]);
#pragma GCC unroll 16
  for (int i = kEven - 2; i >= 0; i -= 2) even = fma(even, square, S(c[i]));
#pragma GCC unroll 16
  for (int i = kOdd - 2; i >= 0; i -= 2) odd = fma(odd, square, S(c[i]));
  return fma(odd, x, even);
}

/// 2^k for integers k within the normal range.
template <Lanewise S>
S power_of_two(Words<S> k) {
  using R = RealOf<S>;
  return from_bits((k + R::kBias) << R::kMantissa);
}

/// The integer nearest to x, as lanes of integers and of reals; |x| < 2^(mantissa - 2).
template <class S>
struct Rounded {
  S real;
  Words<S> integer;
};
template <Lanewise S>
Rounded<S> round_to_integer(S x) {
  using R = RealOf<S>;
  const S shifted = x + S(R::kRound);
  return {shifted - S(R::kRound), to_bits(shifted) - to_bits(S(R::kRound))};
}

/// True where the lane is not zero.
inline bool is_set(std::uint64_t bits) { return bits != 0; }
inline bool is_set(std::uint32_t bits) { return bits != 0; }
template <std::unsigned_integral T, int N>
auto is_set(Pack<T, N> bits) {
  return Mask<decltype(from_bits(T())), N>{bits.v != 0};
}

/// x 2^n for |n| < 2 (kBias - 2), |x| below 4; over- and underflow are rounded once.
template <Lanewise S>
S scale_in_two_steps(S x, Rounded<S> n) {
  const Rounded<S> half = round_to_integer(n.real * S(0.5));
  return x * power_of_two<S>(half.integer) * power_of_two<S>(n.integer - half.integer);
}
template <std::floating_point S>
S scale(S x, Rounded<S> n) {
  return scale_in_two_steps(x, n);
}
template <class T, int N>
Pack<T, N> scale(Pack<T, N> x, Rounded<Pack<T, N>> n) {
#if defined(__AVX512F__)
  using S = Pack<T, N>;
  // Lanes that vanish are left out: underflow takes a hundred cycles.
  using Vector = typename Pack<T, N>::Vector;
  const S vanishes(RealOf<S>::kVanishes);
  if constexpr (sizeof(T) * N == 64 && sizeof(T) == 8) {
    const auto stays = _mm512_cmp_pd_mask((__m512d)n.real.v, (__m512d)vanishes.v, _CMP_NLT_UQ);
    return (Vector)_mm512_maskz_scalef_pd(stays, (__m512d)x.v, (__m512d)n.real.v);
  }
  if constexpr (sizeof(T) * N == 64 && sizeof(T) == 4) {
    const auto stays = _mm512_cmp_ps_mask((__m512)n.real.v, (__m512)vanishes.v, _CMP_NLT_UQ);
    return (Vector)_mm512_maskz_scalef_ps(stays, (__m512)x.v, (__m512)n.real.v);
  }
#endif
  return scale_in_two_steps(x, n);
}

/// x between low and high; NaN stays.
template <Lanewise S, class T>
S clamp_range(S x, T low, T high) {
  return max(S(low), min(S(high), x));
}

/// x = n ln 2 + r with |r| <= ln(2)/2, by Cody and Waite.
template <class S>
struct ReducedExponent {
  S r;
  Rounded<S> n;
};
template <Lanewise S>
ReducedExponent<S> reduce_exponent(S x) {
  using R = RealOf<S>;
  const Rounded<S> n = round_to_integer(x * S(R::kLog2e));
  return {fma(n.real, S(-R::kLn2Low), fma(n.real, S(-R::kLn2High), x)), n};
}

/// c + (e^r - 1) for |r| <= ln(2)/2 and c = 0 or |c| >= |r|: the rounding error of c + r is kept.
template <Lanewise S>
S add_expm1(S c, S r) {
  const S high = c + r;
  const S low = r - (high - c);
  return high + fma(r * r, polynomial(r, RealOf<S>::kExp), low);
}

/// e^x - 1 = y 2^n.
template <class S>
struct Expm1Parts {
  S y;
  Rounded<S> n;
};
template <Lanewise S>
Expm1Parts<S> expm1_parts(S x) {
  using R = RealOf<S>;
  const auto [r, n] = reduce_exponent(clamp_range(x, R::kExpm1Low, R::kExpHigh));
  // y = (1 - 2^-n) + e^r - 1, where 2^-n is exact or far below the last place
  const S inverse = select(n.real > S(64), S(0), power_of_two<S>(Words<S>(0) - n.integer));
  return {add_expm1(S(1) - inverse, r), n};
}

/// x = 2^n m with sqrt(1/2) <= m < sqrt(2), for x > 0.
template <class S>
struct LogParts {
  S n, m;
};
template <Lanewise S>
LogParts<S> log_parts(S x) {
  using R = RealOf<S>;
  const Words<S> half = to_bits(S(R::kSqrtHalf));
  const Words<S> bits = to_bits(x) + (to_bits(S(1)) - half);
  const S n = from_bits((bits >> R::kMantissa) + to_bits(S(R::kRound))) - S(R::kRound);
  return {n - S(R::kBias), from_bits((bits & R::kMantissaMask) + half)};
}
/// The same where x may be subnormal.
template <Lanewise S>
LogParts<S> log_parts_of_any(S x) {
  using R = RealOf<S>;
  constexpr int kShift = R::kMantissa + 2;
  const auto tiny = x < S(R::kSmallestNormal);
  const LogParts<S> e = log_parts(select(tiny, x * power_of_two<S>(Words<S>(kShift)), x));
  return {select(tiny, e.n - S(kShift), e.n), e.m};
}

/// log(1 + f) + n ln 2 + tail, sqrt(1/2) <= 1 + f < sqrt(2), by s = f / (2 + f) and
/// log(1 + f) = f - f^2/2 + s (f^2/2 + s^2 p(s^2)).
template <Lanewise S>
S log_sum(S f, S n, S tail) {
  using R = RealOf<S>;
  const S s = f / (S(2) + f);
  const S z = s * s;
  const S half_square = S(0.5) * f * f;
  const S curved = s * (half_square + z * polynomial(z, R::kLog));
  const S low = curved + fma(n, S(R::kLn2Low), tail);
  return fma(n, S(R::kLn2High), f - (half_square - low));
}

/// log(1 + f) for 0 <= f <= 1, as log_sum.
template <Lanewise S>
S log1p_of_share(S f) {
  const S s = f / (S(2) + f);
  const S z = s * s;
  return f - s * (f - z * polynomial(z, RealOf<S>::kLogWide));
}

/// high + low, |low| <= ulp(high) / 2.
template <class S>
struct Double {
  S high, low;
};

/// log where x is not a positive finite number.
template <Lanewise S>
S log_edge(S x) {
  using R = RealOf<S>;
  return select(x == S(0), S(-R::kInf), select(x < S(0), S(R::kNaN), x));
}

/// Natural logarithm to about 2^-59 (float: 2^-29) of its value, with log's edge values.
template <Lanewise S>
Double<S> log_extended(S x) {
  using R = RealOf<S>;
  const LogParts<S> e = log_parts_of_any(x);
  // s = (m - 1) / (m + 1) with its remainder
  const S f = e.m - S(1);
  const S d = e.m + S(1);
  const S d_low = e.m - (d - S(1));
  const S inverse = S(1) / d;
  const S s = f * inverse;
  const S s_low = (fma(-s, d, f) - s * d_low) * inverse;

  const S a = e.n * S(R::kLn2High);
  const S b = s + s;
  const S sum = a + b;
  const S z = s * s;
  const S rest =
      (a - sum) + b + fma(e.n, S(R::kLn2Low), fma(s * z, polynomial(z, R::kLog), s_low + s_low));
  const S high = sum + rest;
  const auto regular = (x > S(0)) & (x < S(R::kInf));
  return {select(regular, high, log_edge(x)), select(regular, rest - (high - sum), S(0))};
}

}  // namespace detail
}  // namespace fricid
