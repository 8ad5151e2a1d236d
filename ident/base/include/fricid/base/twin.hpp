// Two values of one scalar type, computed side by side.
#pragma once

#include <type_traits>

#include "fricid/base/math.hpp"

namespace fricid {

/// Two S with element-wise arithmetic, equal to the last bit to that of each alone. Where a long
/// chain of operations leaves a processor waiting, it works on two in the same time.
template <class S>
struct Twin {
  S a, b;

  Twin() = default;
  Twin(S first, S second) : a(first), b(second) {}
  template <class U>
  requires std::is_arithmetic_v<U> Twin(U scalar) : a(scalar), b(scalar) {}

  friend Twin operator+(Twin x, Twin y) { return {x.a + y.a, x.b + y.b}; }
  friend Twin operator-(Twin x, Twin y) { return {x.a - y.a, x.b - y.b}; }
  friend Twin operator*(Twin x, Twin y) { return {x.a * y.a, x.b * y.b}; }
  friend Twin operator/(Twin x, Twin y) { return {x.a / y.a, x.b / y.b}; }
  friend Twin operator-(Twin x) { return {-x.a, -x.b}; }
};

template <class S>
Twin<S> abs(Twin<S> x) {
  return {abs(x.a), abs(x.b)};
}
template <class S>
Twin<S> max(Twin<S> x, Twin<S> y) {
  return {max(x.a, y.a), max(x.b, y.b)};
}
template <class S>
Twin<S> exp(Twin<S> x) {
  return {exp(x.a), exp(x.b)};
}
template <class S>
Twin<S> phi1(Twin<S> x) {
  return {phi1(x.a), phi1(x.b)};
}

}  // namespace fricid
