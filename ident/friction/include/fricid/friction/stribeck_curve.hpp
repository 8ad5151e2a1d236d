// The Stribeck curve: friction level falling from Fs at rest to Fc at speed. Shared by stribeck,
// stribeck_peak, lugre and gms.
#pragma once

#include "fricid/base/math.hpp"

namespace fricid::friction {

/// s(v) = Fc + (Fs - Fc) e,  e = exp(-(v/vs)^2)   [N m]
///
/// The exponent of |v/vs| is fixed at 2: s is then smooth at v = 0, and data do not tell it from
/// its neighbours once vs is free.
template <class S>
struct StribeckCurve {
  S e;      ///< in [0, 1]
  S value;  ///< between Fc and Fs [N m]
};

template <class S>
[[gnu::always_inline]] inline StribeckCurve<S> stribeck_curve(const S& Fc, const S& Fs, const S& vs,
                                                              const S& v) {
  const S r = v / vs;
  const S e = decay(r * r);
  return {e, Fc * (S(1) - e) + Fs * e};  // stays positive in single precision too
}

/// Adds the vector-Jacobian product of s (value_bar) and of e (e_bar) to that of Fc, Fs, vs, v.
template <class S>
void stribeck_curve_pullback(const S& Fc, const S& Fs, const S& vs, const S& v,
                             const StribeckCurve<S>& curve, const S& value_bar, const S& e_bar,
                             S& Fc_bar, S& Fs_bar, S& vs_bar, S& v_bar) {
  Fc_bar += value_bar * (S(1) - curve.e);
  Fs_bar += value_bar * curve.e;
  const S r = v / vs;
  const S r_bar = (e_bar + value_bar * (Fs - Fc)) * curve.e * S(-2) * r;
  v_bar += r_bar / vs;
  vs_bar -= r_bar * r / vs;
}

}  // namespace fricid::friction
