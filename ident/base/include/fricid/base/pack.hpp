// Pack<T, N>: N numbers that are computed together. Every template of the engine is written once
// for a scalar type S and instantiated for S = double (one state) and S = Pack (N states).
#pragma once

#if defined(__x86_64__)
#include <immintrin.h>
#endif

#include <algorithm>
#include <bit>
#include <cmath>
#include <concepts>
#include <cstdint>
#include <type_traits>

namespace fricid {

/// Width of the vector registers that the compiler may use, in bytes.
#if defined(__AVX512F__) && defined(__AVX512DQ__)
inline constexpr int kRegisterBytes = 64;
#elif defined(__AVX__)
inline constexpr int kRegisterBytes = 32;
#else
inline constexpr int kRegisterBytes = 16;
#endif

/// How N lanes of T are cut into registers: the compiler takes vectors wider than one apart, lane
/// by lane, so a pack is an array of vectors that fit.
template <class T, int N>
struct Lanes {
  static_assert(std::is_arithmetic_v<T> && N > 0 && (N & (N - 1)) == 0);
  static constexpr int kWidth = std::min(N, kRegisterBytes / static_cast<int>(sizeof(T)));
  static constexpr int kCount = N / kWidth;
  typedef T Vector __attribute__((vector_size(sizeof(T) * kWidth)));
};

/// Result of comparing two packs: one truth value per lane.
template <class T, int N>
struct Mask {
  using Int = std::conditional_t<sizeof(T) == 8, std::int64_t, std::int32_t>;
  using Cut = Lanes<Int, N>;

  typename Cut::Vector m[Cut::kCount];  ///< 0 = false, -1 = true

  bool operator[](int lane) const { return m[lane / Cut::kWidth][lane % Cut::kWidth] != 0; }
  friend Mask operator&(Mask a, Mask b) {
    return make([&](int c) { return a.m[c] & b.m[c]; });
  }
  friend Mask operator|(Mask a, Mask b) {
    return make([&](int c) { return a.m[c] | b.m[c]; });
  }
  friend Mask operator!(Mask a) {
    return make([&](int c) { return ~a.m[c]; });
  }

  /// The mask of the vectors vector(0), vector(1), ...
  template <class Vector>
  static Mask make(Vector vector) {
    Mask r;
    for (int c = 0; c < Cut::kCount; ++c) r.m[c] = vector(c);
    return r;
  }
};

/// N lanes of T with element-wise arithmetic. A scalar converts to N equal lanes. T is double,
/// float, or an unsigned integer for bit patterns.
template <class T, int N>
struct Pack {
  using Scalar = T;
  using Cut = Lanes<T, N>;
  using Vector = typename Cut::Vector;
  static constexpr int kLanes = N;

  Vector v[Cut::kCount];

  Pack() = default;
  template <class U>
  requires std::is_arithmetic_v<U> Pack(U scalar) {
    for (Vector& vector : v) vector = static_cast<T>(scalar) - Vector{};
  }

  T operator[](int lane) const { return v[lane / Cut::kWidth][lane % Cut::kWidth]; }
  void set(int lane, T value) { v[lane / Cut::kWidth][lane % Cut::kWidth] = value; }

  /// The pack of the vectors vector(0), vector(1), ...
  template <class Function>
  static Pack make(Function vector) {
    Pack r;
    for (int c = 0; c < Cut::kCount; ++c) r.v[c] = vector(c);
    return r;
  }

  friend Pack operator+(Pack a, Pack b) {
    return make([&](int c) { return a.v[c] + b.v[c]; });
  }
  friend Pack operator-(Pack a, Pack b) {
    return make([&](int c) { return a.v[c] - b.v[c]; });
  }
  friend Pack operator*(Pack a, Pack b) {
    return make([&](int c) { return a.v[c] * b.v[c]; });
  }
  friend Pack operator/(Pack a, Pack b) {
    return make([&](int c) { return a.v[c] / b.v[c]; });
  }
  friend Pack operator-(Pack a) {
    return make([&](int c) { return -a.v[c]; });
  }
  Pack& operator+=(Pack b) { return *this = *this + b; }
  Pack& operator-=(Pack b) { return *this = *this - b; }
  Pack& operator*=(Pack b) { return *this = *this * b; }
  Pack& operator/=(Pack b) { return *this = *this / b; }

  friend Mask<T, N> operator<(Pack a, Pack b) {
    return Mask<T, N>::make([&](int c) { return a.v[c] < b.v[c]; });
  }
  friend Mask<T, N> operator<=(Pack a, Pack b) {
    return Mask<T, N>::make([&](int c) { return a.v[c] <= b.v[c]; });
  }
  friend Mask<T, N> operator>(Pack a, Pack b) { return b < a; }
  friend Mask<T, N> operator>=(Pack a, Pack b) { return b <= a; }
  friend Mask<T, N> operator==(Pack a, Pack b) {
    return Mask<T, N>::make([&](int c) { return a.v[c] == b.v[c]; });
  }
  friend Mask<T, N> operator!=(Pack a, Pack b) {
    return Mask<T, N>::make([&](int c) { return a.v[c] != b.v[c]; });
  }

  // Bit patterns: unsigned integers only.
  friend Pack operator&(Pack a, Pack b) requires std::unsigned_integral<T> {
    return make([&](int c) { return a.v[c] & b.v[c]; });
  }
  friend Pack operator|(Pack a, Pack b) requires std::unsigned_integral<T> {
    return make([&](int c) { return a.v[c] | b.v[c]; });
  }
  friend Pack operator^(Pack a, Pack b) requires std::unsigned_integral<T> {
    return make([&](int c) { return a.v[c] ^ b.v[c]; });
  }
  friend Pack operator<<(Pack a, int bits) requires std::unsigned_integral<T> {
    return make([&](int c) { return a.v[c] << bits; });
  }
  friend Pack operator>>(Pack a, int bits) requires std::unsigned_integral<T> {
    return make([&](int c) { return a.v[c] >> bits; });
  }
};

/// The widths the engine is built for: one register, 8 and 16 lanes with AVX-512, 4 and 8 with
/// AVX2.
using PackD = Pack<double, kRegisterBytes / 8>;
using PackF = Pack<float, kRegisterBytes / 4>;

template <class S>
inline constexpr bool kIsPack = false;
template <class T, int N>
inline constexpr bool kIsPack<Pack<T, N>> = true;

/// Number of states that a value of type S carries: N for Pack<T, N>, else 1.
template <class S>
inline constexpr int kLaneCount = 1;
template <class T, int N>
inline constexpr int kLaneCount<Pack<T, N>> = N;

// Lane access that also reads for plain scalars.
template <std::floating_point S>
S lane(S x, int) {
  return x;
}
template <class T, int N>
T lane(Pack<T, N> x, int i) {
  return x[i];
}
template <std::floating_point S>
void set_lane(S& x, int, S value) {
  x = value;
}
template <class T, int N>
void set_lane(Pack<T, N>& x, int i, T value) {
  x.set(i, value);
}

// Bit pattern of a number and back, lane for lane.
inline std::uint64_t to_bits(double x) { return std::bit_cast<std::uint64_t>(x); }
inline std::uint32_t to_bits(float x) { return std::bit_cast<std::uint32_t>(x); }
inline double from_bits(std::uint64_t bits) { return std::bit_cast<double>(bits); }
inline float from_bits(std::uint32_t bits) { return std::bit_cast<float>(bits); }
template <class T, int N>
auto to_bits(Pack<T, N> x) {
  using Words = Pack<decltype(to_bits(T())), N>;
  return Words::make([&](int c) { return std::bit_cast<typename Words::Vector>(x.v[c]); });
}
template <std::unsigned_integral T, int N>
auto from_bits(Pack<T, N> bits) {
  using Reals = Pack<decltype(from_bits(T())), N>;
  return Reals::make([&](int c) { return std::bit_cast<typename Reals::Vector>(bits.v[c]); });
}

// select(condition, a, b) is a where the condition holds, else b; both sides are evaluated.
template <class S>
S select(bool condition, S a, S b) {
  return condition ? a : b;
}
template <class T, int N>
Pack<T, N> select(Mask<T, N> condition, std::type_identity_t<Pack<T, N>> a,
                  std::type_identity_t<Pack<T, N>> b) {
  return Pack<T, N>::make([&](int c) { return condition.m[c] ? a.v[c] : b.v[c]; });
}

inline bool any(bool condition) { return condition; }
inline bool all(bool condition) { return condition; }
template <class T, int N>
bool any(Mask<T, N> mask) {
  auto seen = mask.m[0];
  for (int c = 1; c < Mask<T, N>::Cut::kCount; ++c) seen |= mask.m[c];
#if defined(__AVX512F__)
  if constexpr (sizeof(seen) == 64) return _mm512_test_epi32_mask((__m512i)seen, (__m512i)seen);
#endif
#if defined(__AVX__)
  if constexpr (sizeof(seen) == 32) return !_mm256_testz_si256((__m256i)seen, (__m256i)seen);
#endif
  typename Mask<T, N>::Int bits = 0;
  for (int i = 0; i < Mask<T, N>::Cut::kWidth; ++i) bits |= seen[i];
  return bits != 0;
}
template <class T, int N>
bool all(Mask<T, N> mask) {
  return !any(!mask);
}

// Element-wise functions under one name for scalars and packs: call them unqualified after
// `using namespace fricid` or from inside the namespace.
template <std::floating_point S>
S abs(S x) {
  return std::fabs(x);
}
template <class T, int N>
Pack<T, N> abs(Pack<T, N> x) {
  return from_bits(to_bits(x) & (to_bits(T(-0.0)) - 1));
}

template <std::floating_point S>
S sqrt(S x) {
  return std::sqrt(x);
}
template <class T, int N>
Pack<T, N> sqrt(Pack<T, N> x) {
  using Vector = typename Pack<T, N>::Vector;
  return Pack<T, N>::make([&](int c) -> Vector {
#if defined(__AVX512F__)
    if constexpr (sizeof(Vector) == 64 && sizeof(T) == 8)
      return (Vector)_mm512_maskz_sqrt_pd(-1, (__m512d)x.v[c]);
    if constexpr (sizeof(Vector) == 64 && sizeof(T) == 4)
      return (Vector)_mm512_maskz_sqrt_ps(-1, (__m512)x.v[c]);
#endif
#if defined(__AVX__)
    if constexpr (sizeof(Vector) == 32 && sizeof(T) == 8)
      return (Vector)_mm256_sqrt_pd((__m256d)x.v[c]);
    if constexpr (sizeof(Vector) == 32 && sizeof(T) == 4)
      return (Vector)_mm256_sqrt_ps((__m256)x.v[c]);
#endif
    Vector r;
    for (int i = 0; i < Pack<T, N>::Cut::kWidth; ++i) r[i] = std::sqrt(x.v[c][i]);
    return r;
  });
}

/// a b + c with one rounding; one instruction from x86-64-v3 on.
inline double fma(double a, double b, double c) { return __builtin_fma(a, b, c); }
inline float fma(float a, float b, float c) { return __builtin_fmaf(a, b, c); }
template <class T, int N>
Pack<T, N> fma(Pack<T, N> a, std::type_identity_t<Pack<T, N>> b,
               std::type_identity_t<Pack<T, N>> c) {
  using Vector = typename Pack<T, N>::Vector;
  return Pack<T, N>::make([&](int k) -> Vector {
#if defined(__AVX512F__)
    if constexpr (sizeof(Vector) == 64 && sizeof(T) == 8)
      return (Vector)_mm512_fmadd_pd((__m512d)a.v[k], (__m512d)b.v[k], (__m512d)c.v[k]);
    if constexpr (sizeof(Vector) == 64 && sizeof(T) == 4)
      return (Vector)_mm512_fmadd_ps((__m512)a.v[k], (__m512)b.v[k], (__m512)c.v[k]);
#endif
#if defined(__FMA__)
    if constexpr (sizeof(Vector) == 32 && sizeof(T) == 8)
      return (Vector)_mm256_fmadd_pd((__m256d)a.v[k], (__m256d)b.v[k], (__m256d)c.v[k]);
    if constexpr (sizeof(Vector) == 32 && sizeof(T) == 4)
      return (Vector)_mm256_fmadd_ps((__m256)a.v[k], (__m256)b.v[k], (__m256)c.v[k]);
#endif
    Vector r;
    for (int i = 0; i < Pack<T, N>::Cut::kWidth; ++i) r[i] = fma(a.v[k][i], b.v[k][i], c.v[k][i]);
    return r;
  });
}

/// The smaller (larger) argument; b where one of them is NaN.
template <class S>
S min(S a, std::type_identity_t<S> b) {
  return select(a < b, a, b);
}
template <class S>
S max(S a, std::type_identity_t<S> b) {
  return select(a > b, a, b);
}
template <class S>
S clamp(S x, std::type_identity_t<S> low, std::type_identity_t<S> high) {
  return min(max(x, low), high);
}

/// -1, 0 or 1 (0 at x = 0).
template <class S>
S sign(S x) {
  return select(x > S(0), S(1), select(x < S(0), S(-1), S(0)));
}

}  // namespace fricid
