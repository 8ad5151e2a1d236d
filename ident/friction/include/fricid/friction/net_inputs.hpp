// Inputs of the networks of a learned law, from velocity and load.
#pragma once

#include <array>

#include "fricid/base/math.hpp"
#include "fricid/friction/law.hpp"

namespace fricid::friction {

/// Inputs of a network, all of order one:
///
///     v/v_ref,   tanh(v/v1),   tanh(v/v2),   |load|/load_ref
///
/// The two saturated ones distinguish presliding, the Stribeck range and sliding. The scales are
/// kSize consecutive parameters of the law.
template <class S>
struct NetInputs {
  enum Index { kVRef, kV1, kV2, kLoadRef, kSize };

  S v, v1, v2, load;

  /// @param scales  the first of them in theta
  static NetInputs of(const S* scales, const S& v, const S& load) {
    return {v / scales[kVRef], tanh(v / scales[kV1]), tanh(v / scales[kV2]),
            abs(load) / scales[kLoadRef]};
  }

  /// Those of |v|.
  NetInputs ahead() const { return {abs(v), abs(v1), abs(v2), load}; }

  /// Adds the vector-Jacobian product of `of`; `bar` has that of each input.
  void pull_back(const S* scales, const S& motion, const S& torque, const NetInputs& bar,
                 S* scales_bar, S& motion_bar, S& torque_bar) const {
    const auto quotient = [&](int scale, const S& numerator, const S& r_bar) {
      const S inverse = S(1) / scales[scale];
      scales_bar[scale] -= r_bar * numerator * inverse * inverse;
      return r_bar * inverse;
    };
    motion_bar += quotient(kVRef, motion, bar.v) +
                  quotient(kV1, motion, bar.v1 * (S(1) - v1 * v1)) +
                  quotient(kV2, motion, bar.v2 * (S(1) - v2 * v2));
    torque_bar += sign(torque) * quotient(kLoadRef, abs(torque), bar.load);
  }
};

/// Rows of the parameter table for the scales.
inline constexpr std::array<ParameterInfo, NetInputs<double>::kSize> kNetInputScales{{
    {"v_ref", "rad/s", Role::kSpeedScale, 1e-2, 1e3, 3.3, Scale::kLog, "input scale: speed"},
    {"v1", "rad/s", Role::kSaturationSpeed, 1e-4, 1e2, 0.05, Scale::kLog,
     "input scale: speed of presliding"},
    {"v2", "rad/s", Role::kSaturationSpeed, 1e-4, 1e2, 0.4, Scale::kLog,
     "input scale: speed of the Stribeck range"},
    {"load_ref", "N m", Role::kLoadScale, 1e-3, 1e5, 50, Scale::kLog, "input scale: load"},
}};

}  // namespace fricid::friction
