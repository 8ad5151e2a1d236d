// Several values of one scalar type, computed side by side.
#pragma once

#include <type_traits>

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

  friend Group operator+(const Group& a, const Group& b) {
    return each([](S p, S q) { return p + q; }, a, b);
  }
  friend Group operator-(const Group& a, const Group& b) {
    return each([](S p, S q) { return p - q; }, a, b);
  }
  friend Group operator*(const Group& a, const Group& b) {
    return each([](S p, S q) { return p * q; }, a, b);
  }
  friend Group operator/(const Group& a, const Group& b) {
    return each([](S p, S q) { return p / q; }, a, b);
  }
  friend Group operator-(const Group& a) {
    return each([](S p) { return -p; }, a);
  }
  friend Group abs(const Group& a) {
    return each([](S p) { return abs(p); }, a);
  }
  friend Group decay(const Group& a) {
    return each([](S p) { return decay(p); }, a);
  }
  friend Group sign(const Group& a) {
    return each([](S p) { return sign(p); }, a);
  }

 private:
  template <class F, class... G>
  [[gnu::always_inline]] static Group each(F f, const G&... g) {
    Group y;
#pragma GCC unroll 8
    for (int i = 0; i < N; ++i) y.x[i] = f(g.x[i]...);
    return y;
  }
};

}  // namespace fricid
