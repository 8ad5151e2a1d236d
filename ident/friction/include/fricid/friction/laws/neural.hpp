#pragma once

#include <array>
#include <span>
#include <string_view>

#include "fricid/base/math.hpp"
#include "fricid/base/rng.hpp"
#include "fricid/friction/elements.hpp"
#include "fricid/friction/law.hpp"
#include "fricid/friction/mlp.hpp"
#include "fricid/friction/net_inputs.hpp"

namespace fricid::friction {

/// Friction without memory as Coulomb and viscous friction plus a network:
///
///     tau = Fc (tanh(v/v0) + n(x)) + Fv v,   n(x) = y(x) - y(x~)
///     x   = (v/v_ref, tanh(v/v1), tanh(v/v2), |load|/load_ref),   x~: all negated but |load|
///
/// y has two hidden layers of `elements` Mish units; n is odd in v by construction, but not
/// dissipative. No state.
class Neural {
 public:
  enum Index { kFc, kV0, kFv, kScales, kCommon = kScales + NetInputs<double>::kSize };

  static constexpr std::string_view kName = "neural";
  static constexpr std::string_view kEquation =
      "tau = Fc (tanh(v/v0) + n) + Fv v, n odd = net(v, |load|), two hidden layers of `elements` "
      "units";
  static constexpr std::string_view kSource = "Mish: Misra, BMVC 2020";
  static constexpr PlotLook kLook{"#8C7A00", 8};
  static constexpr Claims kClaims{.dissipative = false};
  static constexpr Reads kReads{.load = true};
  static constexpr int kMostElements = 32;

  /// @param elements  width of the hidden layers, 1 .. kMostElements
  explicit constexpr Neural(int elements) : net_(elements) {}

  static constexpr int state_size() { return 0; }
  constexpr std::span<const ParameterInfo> parameters() const {
    return std::span(kTable).first(static_cast<std::size_t>(kCommon + net_.weight_count()));
  }

  /// Random initial weights with a small output, so that the law starts as Coulomb and viscous
  /// friction.
  void initialise(double* theta, Rng& rng) const {
    constexpr double kOutputScale = 0.01;
    net_.initialise(theta + kCommon, rng, kOutputScale);
  }

  template <class S>
  S torque(const S* theta, const Input<S>& in, const S*) const {
    S x[kInputs * 2], y[2];
    mirrored(NetInputs<S>::of(theta + kScales, in.v, in.load), x);
    net_.template forward<2>(theta + kCommon, x, y);
    return theta[kFc] * (tanh(in.v / theta[kV0]) + (y[0] - y[1])) + theta[kFv] * in.v;
  }

  template <class S>
  void step(const S*, const Input<S>&, double, S*) const {}

  template <class S>
  void torque_pullback(const S* theta, const Input<S>& in, const S*, const S& tau_bar, S* theta_bar,
                       Input<S>& in_bar, S*) const {
    const NetInputs<S> features = NetInputs<S>::of(theta + kScales, in.v, in.load);
    S x[kInputs * 2], y[2];
    mirrored(features, x);
    Net::template Tape<2, S> tape;
    net_.template forward<2>(theta + kCommon, x, y, tape);

    const S v_per_v0 = in.v / theta[kV0];
    const S t = tanh(v_per_v0);
    const S n_bar = tau_bar * theta[kFc];
    const S t_bar = n_bar * (S(1) - t * t) / theta[kV0];
    theta_bar[kFc] += tau_bar * (t + (y[0] - y[1]));
    theta_bar[kV0] -= t_bar * v_per_v0;
    theta_bar[kFv] += tau_bar * in.v;
    in_bar.v += t_bar + tau_bar * theta[kFv];

    const S y_bar[2] = {n_bar, -n_bar};
    S x_bar[kInputs * 2];
    for (S& bar : x_bar) bar = S(0);
    net_.template pullback<2>(theta + kCommon, x, tape, y_bar, theta_bar + kCommon, x_bar);
    features.pull_back(
        theta + kScales, in.v, in.load,
        {x_bar[0] - x_bar[1], x_bar[2] - x_bar[3], x_bar[4] - x_bar[5], x_bar[6] + x_bar[7]},
        theta_bar + kScales, in_bar.v, in_bar.load);
  }

  template <class S>
  void step_pullback(const S*, const Input<S>&, double, const S*, const S*, S*, Input<S>&,
                     S*) const {}

  template <class S>
  S steady_torque(const S* theta, const Input<S>& in) const {
    return torque(theta, in, static_cast<const S*>(nullptr));
  }

 private:
  static constexpr int kInputs = 4;
  using Net = Mlp<Activation::kMish, kInputs, 2, 1, kMostElements>;

  template <class S>  // x and its mirror image, side by side
  static void mirrored(const NetInputs<S>& features, S* x) {
    const S odd[3] = {features.v, features.v1, features.v2};
    for (int i = 0; i < 3; ++i) {
      x[2 * i] = odd[i];
      x[2 * i + 1] = -odd[i];
    }
    x[6] = x[7] = features.load;
  }

  static constexpr auto kTable = [] {
    std::array<ParameterInfo, kCommon> common{{
        {"Fc", "N m", Role::kNetworkTorque, 1e-6, 1e6, 5, Scale::kLog,
         "Coulomb friction, size of the network's torque"},
        {"v0", "rad/s", Role::kSmoothingSpeed, 1e-5, 1, 0.05, Scale::kLog, "smoothing speed"},
        {"Fv", "N m s/rad", Role::kViscous, 0, 1e6, 2.5, Scale::kLinear, "viscous coefficient"},
    }};
    for (std::size_t i = 0; i < kNetInputScales.size(); ++i)
      common[kScales + i] = kNetInputScales[i];
    return weight_table<Net(kMostElements).weight_count()>(common);
  }();

  Net net_;
};

}  // namespace fricid::friction
