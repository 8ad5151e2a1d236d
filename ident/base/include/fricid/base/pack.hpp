// Pack<T, N>: N numbers that are computed together. Every template of the engine is written once
// for a scalar type S and instantiated for S = double (one state) and S = Pack (N states).
#pragma once

#if defined(__x86_64__)
#include <immintrin.h>
#endif

#include <bit>
#include <cmath>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <type_traits>

namespace fricid {

/// Width of the vector registers that the compiler may use, in bytes.
#if defined(__AVX512F__)
inline constexpr int kRegisterBytes = 64;
#elif defined(__AVX__)
inline constexpr int kRegisterBytes = 32;
#else
inline constexpr int kRegisterBytes = 16;
#endif

/// Result of comparing two packs: one truth value per lane.
template <class T, int N>
struct Mask {
  using Int = std::conditional_t<sizeof(T) == 8, std::int64_t, std::int32_t>;
  typedef Int Vector __attribute__((vector_size(sizeof(T) * N)));

  Vector m;  ///< 0 = false, -1 = true

  bool operator[](int lane) const { return m[lane] != 0; }
  friend Mask operator&(Mask a, Mask b) { return {a.m & b.m}; }
  friend Mask operator|(Mask a, Mask b) { return {a.m | b.m}; }
  friend Mask operator!(Mask a) { return {~a.m}; }
};

/// N lanes of T with element-wise arithmetic, at most one register: compilers take wider vectors
/// apart, lane by lane. A scalar converts to N equal lanes. T is double, float, or an unsigned
/// integer for bit patterns.
template <class T, int N>
struct Pack {
  static_assert(std::is_arithmetic_v<T> && N > 0 && (N & (N - 1)) == 0);
  static_assert(sizeof(T) * N <= kRegisterBytes, "N lanes must fit one register: see PackD, PackF");
  using Scalar = T;
  static constexpr int kLanes = N;
  typedef T Vector __attribute__((vector_size(sizeof(T) * N)));

  Vector v;

  Pack() = default;
  Pack(Vector vector) : v(vector) {}
  template <class U>
  requires std::is_arithmetic_v<U> Pack(U scalar) : v(static_cast<T>(scalar) - Vector{}) {}

  T operator[](int lane) const { return v[lane]; }
  void set(int lane, T value) { v[lane] = value; }

  friend Pack operator+(Pack a, Pack b) { return a.v + b.v; }
  friend Pack operator-(Pack a, Pack b) { return a.v - b.v; }
  friend Pack operator*(Pack a, Pack b) { return a.v * b.v; }
  friend Pack operator/(Pack a, Pack b) { return a.v / b.v; }
  friend Pack operator-(Pack a) { return -a.v; }
  Pack& operator+=(Pack b) { return v += b.v, *this; }
  Pack& operator-=(Pack b) { return v -= b.v, *this; }
  Pack& operator*=(Pack b) { return v *= b.v, *this; }
  Pack& operator/=(Pack b) { return v /= b.v, *this; }

  friend Mask<T, N> operator<(Pack a, Pack b) { return {a.v < b.v}; }
  friend Mask<T, N> operator<=(Pack a, Pack b) { return {a.v <= b.v}; }
  friend Mask<T, N> operator>(Pack a, Pack b) { return {a.v > b.v}; }
  friend Mask<T, N> operator>=(Pack a, Pack b) { return {a.v >= b.v}; }
  friend Mask<T, N> operator==(Pack a, Pack b) { return {a.v == b.v}; }
  friend Mask<T, N> operator!=(Pack a, Pack b) { return {a.v != b.v}; }

  // Bit patterns: unsigned integers only.
  friend Pack operator&(Pack a, Pack b) { return a.v & b.v; }
  friend Pack operator|(Pack a, Pack b) { return a.v | b.v; }
  friend Pack operator^(Pack a, Pack b) { return a.v ^ b.v; }
  friend Pack operator<<(Pack a, int bits) { return a.v << bits; }
  friend Pack operator>>(Pack a, int bits) { return a.v >> bits; }
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
  return Words((typename Words::Vector)x.v);
}
template <std::unsigned_integral T, int N>
auto from_bits(Pack<T, N> bits) {
  using Reals = Pack<decltype(from_bits(T())), N>;
  return Reals((typename Reals::Vector)bits.v);
}

// select(condition, a, b) is a where the condition holds, else b; both sides are evaluated.
template <class S>
S select(bool condition, S a, S b) {
  return condition ? a : b;
}
template <class T, int N>
Pack<T, N> select(Mask<T, N> condition, std::type_identity_t<Pack<T, N>> a,
                  std::type_identity_t<Pack<T, N>> b) {
  return condition.m ? a.v : b.v;
}

inline bool any(bool condition) { return condition; }
inline bool all(bool condition) { return condition; }
template <class T, int N>
bool any(Mask<T, N> mask) {
#if defined(__AVX512F__)
  if constexpr (sizeof(T) * N == 64)
    return _mm512_test_epi32_mask((__m512i)mask.m, (__m512i)mask.m) != 0;
#endif
#if defined(__AVX__)
  if constexpr (sizeof(T) * N == 32) return !_mm256_testz_si256((__m256i)mask.m, (__m256i)mask.m);
#endif
  typename Mask<T, N>::Int bits = 0;
  for (int i = 0; i < N; ++i) bits |= mask.m[i];
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
  constexpr std::size_t kBytes = sizeof(T) * N;
#if defined(__AVX512F__)
  if constexpr (kBytes == 64 && sizeof(T) == 8)
    return (Vector)_mm512_maskz_sqrt_pd(0xFF, (__m512d)x.v);
  if constexpr (kBytes == 64 && sizeof(T) == 4)
    return (Vector)_mm512_maskz_sqrt_ps(0xFFFF, (__m512)x.v);
#endif
#if defined(__AVX__)
  if constexpr (kBytes == 32 && sizeof(T) == 8) return (Vector)_mm256_sqrt_pd((__m256d)x.v);
  if constexpr (kBytes == 32 && sizeof(T) == 4) return (Vector)_mm256_sqrt_ps((__m256)x.v);
#endif
  Vector r;
  for (int i = 0; i < N; ++i) r[i] = std::sqrt(x.v[i]);
  return r;
}

/// a b + c with one rounding; one instruction from x86-64-v3 on.
template <std::floating_point S>
S fma(S a, std::type_identity_t<S> b, std::type_identity_t<S> c) {
  return std::fma(a, b, c);
}
template <class T, int N>
Pack<T, N> fma(Pack<T, N> a, std::type_identity_t<Pack<T, N>> b,
               std::type_identity_t<Pack<T, N>> c) {
  using Vector = typename Pack<T, N>::Vector;
  constexpr std::size_t kBytes = sizeof(T) * N;
#if defined(__AVX512F__)
  if constexpr (kBytes == 64 && sizeof(T) == 8)
    return (Vector)_mm512_fmadd_pd((__m512d)a.v, (__m512d)b.v, (__m512d)c.v);
  if constexpr (kBytes == 64 && sizeof(T) == 4)
    return (Vector)_mm512_fmadd_ps((__m512)a.v, (__m512)b.v, (__m512)c.v);
#endif
#if defined(__FMA__)
  if constexpr (kBytes == 32 && sizeof(T) == 8)
    return (Vector)_mm256_fmadd_pd((__m256d)a.v, (__m256d)b.v, (__m256d)c.v);
  if constexpr (kBytes == 32 && sizeof(T) == 4)
    return (Vector)_mm256_fmadd_ps((__m256)a.v, (__m256)b.v, (__m256)c.v);
#endif
  Vector r;
  for (int i = 0; i < N; ++i) r[i] = fma(a.v[i], b.v[i], c.v[i]);
  return r;
}

/// The smaller (larger) argument; b where they are equal or one of them is NaN.
template <class S>
S min(S a, std::type_identity_t<S> b) {
  return select(a < b, a, b);
}
template <class S>
S max(S a, std::type_identity_t<S> b) {
  return select(a > b, a, b);
}
#if defined(__AVX512F__)
// One instruction each with exactly that meaning.
inline Pack<double, 8> min(Pack<double, 8> a, Pack<double, 8> b) {
  return (Pack<double, 8>::Vector)_mm512_maskz_min_pd(0xFF, (__m512d)a.v, (__m512d)b.v);
}
inline Pack<double, 8> max(Pack<double, 8> a, Pack<double, 8> b) {
  return (Pack<double, 8>::Vector)_mm512_maskz_max_pd(0xFF, (__m512d)a.v, (__m512d)b.v);
}
inline Pack<float, 16> min(Pack<float, 16> a, Pack<float, 16> b) {
  return (Pack<float, 16>::Vector)_mm512_maskz_min_ps(0xFFFF, (__m512)a.v, (__m512)b.v);
}
inline Pack<float, 16> max(Pack<float, 16> a, Pack<float, 16> b) {
  return (Pack<float, 16>::Vector)_mm512_maskz_max_ps(0xFFFF, (__m512)a.v, (__m512)b.v);
}
#endif
#if defined(__AVX__)
inline Pack<double, 4> min(Pack<double, 4> a, Pack<double, 4> b) {
  return (Pack<double, 4>::Vector)_mm256_min_pd((__m256d)a.v, (__m256d)b.v);
}
inline Pack<double, 4> max(Pack<double, 4> a, Pack<double, 4> b) {
  return (Pack<double, 4>::Vector)_mm256_max_pd((__m256d)a.v, (__m256d)b.v);
}
inline Pack<float, 8> min(Pack<float, 8> a, Pack<float, 8> b) {
  return (Pack<float, 8>::Vector)_mm256_min_ps((__m256)a.v, (__m256)b.v);
}
inline Pack<float, 8> max(Pack<float, 8> a, Pack<float, 8> b) {
  return (Pack<float, 8>::Vector)_mm256_max_ps((__m256)a.v, (__m256)b.v);
}
#endif
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
