// Several values of one scalar type, computed side by side.
#pragma once

#include <type_traits>
#include <utility>

#include "fricid/base/math.hpp"

namespace fricid {

/// N values of S with element-wise arithmetic, bit for bit equal to N separate computations. Hides
/// the latency of long chains of operations: the processor works on several values at once.
template <class S, int N>
struct Group {
  S x[N];

  Group() = default;
  template <class U>
  requires std::is_arithmetic_v<U> Group(U scalar) {
    for (S& value : x) value = S(scalar);
  }
  /// Value i is f(i).
  template <class F>
  [[gnu::always_inline]] static Group of(F f) {
    Group y;
    // written out: a loop would keep groups in memory
    const auto write = [&]<int... i>(std::integer_sequence<int, i...>) { ((y.x[i] = f(i)), ...); };
    write(std::make_integer_sequence<int, N>());
    return y;
  }

  friend Group operator+(Group a, Group b) {
    return of([&](int i) { return a.x[i] + b.x[i]; });
  }
  friend Group operator-(Group a, Group b) {
    return of([&](int i) { return a.x[i] - b.x[i]; });
  }
  friend Group operator*(Group a, Group b) {
    return of([&](int i) { return a.x[i] * b.x[i]; });
  }
  friend Group operator/(Group a, Group b) {
    return of([&](int i) { return a.x[i] / b.x[i]; });
  }
  friend Group operator-(Group a) {
    return of([&](int i) { return -a.x[i]; });
  }
  friend Group min(Group a, Group b) {
    return of([&](int i) { return min(a.x[i], b.x[i]); });
  }
  friend Group max(Group a, Group b) {
    return of([&](int i) { return max(a.x[i], b.x[i]); });
  }
  friend Group fma(Group a, Group b, Group c) {
    return of([&](int i) { return fma(a.x[i], b.x[i], c.x[i]); });
  }
  friend Group abs(Group a) {
    return of([&](int i) { return abs(a.x[i]); });
  }
  friend Group decay(Group a) {
    return of([&](int i) { return decay(a.x[i]); });
  }
  friend Group sign(Group a) {
    return of([&](int i) { return sign(a.x[i]); });
  }
  friend auto lane(Group a, int i) { return lane(a.x[0], i); }
};

template <class S, int N>
[[gnu::flatten]] Group<S, N> exp(Group<S, N> x) {
  using Several = Group<S, N>;
  using R = detail::RealOf<S>;
  detail::ReducedExponent<S> e[N];
  const Several r = Several::of([&](int i) {
    e[i] = detail::reduce_exponent(detail::clamp_range(x.x[i], R::kExpLow, R::kExpHigh));
    return e[i].r;
  });
  const Several y = detail::add_expm1(Several(1), r);
  return Several::of([&](int i) { return detail::scale(y.x[i], e[i].n); });
}

}  // namespace fricid
