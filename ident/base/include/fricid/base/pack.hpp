// Pack<T, N>: N numbers that are computed together. Every template of the engine is written once
// for a scalar type S and instantiated for S = double (one state) and S = Pack (N states).
#pragma once

#include <cmath>
#include <concepts>
#include <cstdint>
#include <type_traits>

namespace fricid {

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

/// N lanes of T with element-wise arithmetic. A scalar converts to N equal lanes.
template <class T, int N>
struct Pack {
  static_assert(std::is_floating_point_v<T> && (N & (N - 1)) == 0);
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
};

/// The widths the engine is built for: one AVX-512 register (two AVX2 registers).
using PackD = Pack<double, 8>;
using PackF = Pack<float, 16>;

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
  for (int i = 0; i < N; ++i)
    if (mask[i]) return true;
  return false;
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
  using Int = typename Mask<T, N>::Vector;
  const Int magnitude = ~(Int)(Pack<T, N>(T(-0.0)).v);
  return (typename Pack<T, N>::Vector)((Int)x.v & magnitude);
}

template <std::floating_point S>
S sqrt(S x) {
  return std::sqrt(x);
}
template <class T, int N>
Pack<T, N> sqrt(Pack<T, N> x) {
  Pack<T, N> r;
  for (int i = 0; i < N; ++i) r.v[i] = std::sqrt(x.v[i]);
  return r;
}

/// a b + c with one rounding; one instruction from x86-64-v3 on.
inline double fma(double a, double b, double c) { return __builtin_fma(a, b, c); }
inline float fma(float a, float b, float c) { return __builtin_fmaf(a, b, c); }
template <class T, int N>
Pack<T, N> fma(Pack<T, N> a, std::type_identity_t<Pack<T, N>> b,
               std::type_identity_t<Pack<T, N>> c) {
  Pack<T, N> r;
  for (int i = 0; i < N; ++i) r.v[i] = fma(a.v[i], b.v[i], c.v[i]);
  return r;
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
