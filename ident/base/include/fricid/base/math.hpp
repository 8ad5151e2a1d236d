// Elementary functions as polynomials on any scalar type of the engine, so that lane k of a pack and
// a plain double give the same bits, vectorised under strict floating point.
#pragma once

#include "fricid/base/pack.hpp"

namespace fricid {

/// sin and cos of the same angle [rad].
template <class S>
struct SinCos {
  S sin, cos;
};

// Implemented for S = double, float, Pack<double, N>, Pack<float, N>:
//   S exp(S), S expm1(S), S log(S), S log1p(S), SinCos<S> sincos(S), S tanh(S),
//   S softplus(S)  log(1 + e^x),  S mish(S)  x tanh(softplus x),
//   S phi1(S)  (e^x - 1) / x, 1 at x = 0,  S pow(S x, S y) for x >= 0

}  // namespace fricid
