#pragma once

#include <array>
#include <span>
#include <string_view>

#include "fricid/base/math.hpp"
#include "fricid/friction/elements.hpp"
#include "fricid/friction/law.hpp"

namespace fricid::friction {

/// N springs in parallel, each of which slips at its cap (Maxwell slip; Prandtl-Ishlinskii
/// operator):
///
///     z_i' = clamp(z_i + v dt, -W_i/K_i, W_i/K_i),    tau = sum_i K_i z_i
///
/// Rate independent, hysteresis with non-local memory, Masing's rules: a branch after a reversal is
/// the virgin curve, scaled by 2. `step` is exact for any motion of one sign. Viscous friction is a
/// law of its own. State: z_i (N), spring deflections [rad].
class MaxwellSlip {
 public:
  static constexpr std::string_view kName = "maxwell_slip";
  static constexpr std::string_view kEquation =
      "z_i' = clamp(z_i + v dt, +-W_i/K_i); tau = sum K_i z_i";
  static constexpr std::string_view kSource =
      "Iwan, J. Appl. Mech. 33, 1966; Goldfarb & Celanovic, IEEE Control Systems 17(3), 1997";
  static constexpr PlotLook kLook{"#7A5230", 6};
  static constexpr Claims kClaims{};
  static constexpr Reads kReads{};
  static constexpr int kMostElements = kMaxElements;
  static constexpr std::string_view kStateUnit = "rad";

  /// @param elements N, 1 .. kMaxElements
  explicit constexpr MaxwellSlip(int elements) : n_(elements) {}

  constexpr int state_size() const { return n_; }
  constexpr std::span<const ParameterInfo> parameters() const {
    return std::span(kTables[static_cast<std::size_t>(n_)]).first(static_cast<std::size_t>(2 * n_));
  }
  /// Indices in theta.
  static constexpr int K(int i) { return 2 * i; }
  static constexpr int W(int i) { return 2 * i + 1; }

  template <class S>
  S torque(const S* theta, const Input<S>&, const S* z) const {
    S tau = S(0);
    for (int i = 0; i < n_; ++i) tau += theta[K(i)] * z[i];
    return tau;
  }

  template <class S>
  void step(const S* theta, const Input<S>& in, double dt, S* z) const {
    const S travel = in.v * S(dt);
    for (int i = 0; i < n_; ++i) {
      const S cap = theta[W(i)] / theta[K(i)];
      z[i] = clamp(z[i] + travel, -cap, cap);
    }
  }

  template <class S>
  void torque_pullback(const S* theta, const Input<S>&, const S* z, const S& tau_bar, S* theta_bar,
                       Input<S>&, S* z_bar) const {
    for (int i = 0; i < n_; ++i) {
      theta_bar[K(i)] += tau_bar * z[i];
      z_bar[i] += tau_bar * theta[K(i)];
    }
  }

  template <class S>
  void step_pullback(const S* theta, const Input<S>& in, double dt, const S* z, const S* z_next_bar,
                     S* theta_bar, Input<S>& in_bar, S* z_bar) const {
    const S travel = in.v * S(dt);
    for (int i = 0; i < n_; ++i) {
      const S cap = theta[W(i)] / theta[K(i)];
      const S free = z[i] + travel;
      const S moves_bar = select(abs(free) < cap, z_next_bar[i], S(0));
      z_bar[i] += moves_bar;
      in_bar.v += moves_bar * S(dt);
      const S cap_bar = (z_next_bar[i] - moves_bar) * sign(free);
      theta_bar[W(i)] += cap_bar / theta[K(i)];
      theta_bar[K(i)] -= cap_bar * cap / theta[K(i)];
    }
  }

  /// v = 0 returns 0.
  template <class S>
  S steady_torque(const S* theta, const Input<S>& in) const {
    S level = S(0);
    for (int i = 0; i < n_; ++i) level += theta[W(i)];
    return level * sign(in.v);
  }

  void state_bound(const double* theta, double, double* bound) const {
    for (int i = 0; i < n_; ++i) bound[i] = theta[W(i)] / theta[K(i)];
  }

 private:
  // typical: 5 N m shared equally, presliding lengths spread from 0.2 to 4 mrad
  static constexpr double kTorqueTypical = 5;
  static constexpr auto kTables = element_tables(std::array<ParameterInfo, 0>{}, [](int i, int n) {
    return std::array<ParameterInfo, 2>{{
        {numbered<"K">(i), "N m/rad", Role::kStiffness, 1e-4, 1e9,
         kTorqueTypical / n / typical_length(i, n), Scale::kLog, "stiffness of the element", i + 1},
        {numbered<"W">(i), "N m", Role::kLevel, 1e-8, 1e6, kTorqueTypical / n, Scale::kLog,
         "torque at which it slips", i + 1},
    }};
  });

  int n_;
};

}  // namespace fricid::friction
