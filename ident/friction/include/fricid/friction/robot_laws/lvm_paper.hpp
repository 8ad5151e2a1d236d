#pragma once

#include <string_view>
#include <vector>

#include "fricid/base/math.hpp"
#include "fricid/base/rng.hpp"
#include "fricid/friction/law.hpp"
#include "fricid/friction/mlp.hpp"
#include "fricid/friction/signal_scales.hpp"

namespace fricid::friction {

/// The latent-variable model as published: one network says the friction torque of the whole robot,
/// another the rate of two latent states, both from everything there is,
///
///     x = ((q - q_mean)/q_sd, v/v_sd, z),    tau_f = tau_sd o y(x),    dz/dt = eta(x) 1/s.
///
/// y has two hidden layers of `elements` Mish units, eta one. `step` is an explicit Euler step, and
/// holds |z_i| <= kMost, since nothing in eta keeps z from running away. State: z (2).
class LvmPaper {
 public:
  static constexpr std::string_view kName = "lvm_paper";
  static constexpr std::string_view kEquation =
      "tau_f = tau_sd net(x), dz/dt = eta(x), x = ((q - q_mean)/q_sd, v/v_sd, z), |z| <= 10; "
      "net has two hidden layers of `elements` Mish units, eta one";
  static constexpr std::string_view kSource =
      "Vantilborgh et al., Probabilistic latent variable modeling for dynamic friction "
      "identification and estimation, 2024";
  static constexpr PlotLook kLook{"#4169E1", 4};
  static constexpr int kMostElements = 32;
  static constexpr std::string_view kStateUnit = "1";
  static constexpr int kLatents = 2;
  static constexpr double kMost = 10;  ///< largest |z_i|

  /// @param joints    1 .. kMostJoints
  /// @param elements  width of the hidden layers, 1 .. kMostElements
  constexpr LvmPaper(int joints, int elements)
      : scales_(joints),
        net_(elements, scales_.inputs() + kLatents, joints),
        eta_(elements, scales_.inputs() + kLatents, kLatents) {}

  static constexpr int state_size() { return kLatents; }
  std::vector<ParameterInfo> parameters() const {
    std::vector<ParameterInfo> table;
    scales_.append_parameters(table);
    append_weights(net_.weight_count() + eta_.weight_count(), table);
    return table;
  }

  /// Starts the weights: eta at random as published, so that z drifts by some tenths per second,
  /// the torque small.
  void initialise(double* theta, Rng& rng) const {
    constexpr double kTorqueScale = 0.1, kRateScale = 0.3;
    net_.initialise(theta + net_begin(), rng, kTorqueScale);
    eta_.initialise(theta + eta_begin(), rng, kRateScale);
  }

  template <class S>
  void add_torque(const S* theta, const Input<S>* in, const S* z, S* tau_f) const {
    S x[kMostInputs] = {}, y[kMostJoints] = {};
    see(theta, in, z, x);
    net_.template forward<1>(theta + net_begin(), x, y);
    scales_.say(theta, y, tau_f);
  }

  template <class S>
  void step(const S* theta, const Input<S>* in, double dt, S* z) const {
    S x[kMostInputs] = {}, y[kLatents] = {};
    see(theta, in, z, x);
    eta_.template forward<1>(theta + eta_begin(), x, y);
    const S h(dt);
    for (int i = 0; i < kLatents; ++i) z[i] = max(S(-kMost), min(S(kMost), z[i] + h * y[i]));
  }

  template <class S>
  void torque_pullback(const S* theta, const Input<S>* in, const S* z, const S* tau_f_bar,
                       S* theta_bar, Input<S>* in_bar, S* z_bar) const {
    S x[kMostInputs] = {}, y[kMostJoints] = {}, y_bar[kMostJoints] = {};
    Net::Tape<1, S> tape;
    see(theta, in, z, x);
    net_.template forward<1>(theta + net_begin(), x, y, tape);
    scales_.say_pullback(theta, y, tau_f_bar, theta_bar, y_bar);
    S x_bar[kMostInputs] = {};
    net_.template pullback<1>(theta + net_begin(), x, tape, y_bar, theta_bar + net_begin(), x_bar);
    see_pullback(theta, x, x_bar, theta_bar, in_bar, z_bar);
  }

  template <class S>
  void step_pullback(const S* theta, const Input<S>* in, double dt, const S* z, const S* z_next_bar,
                     S* theta_bar, Input<S>* in_bar, S* z_bar) const {
    S x[kMostInputs] = {}, y[kLatents] = {}, y_bar[kLatents] = {};
    Eta::Tape<1, S> tape;
    see(theta, in, z, x);
    eta_.template forward<1>(theta + eta_begin(), x, y, tape);
    const S h(dt);
    for (int i = 0; i < kLatents; ++i) {
      const S free = select(abs(z[i] + h * y[i]) < S(kMost), z_next_bar[i], S(0));
      z_bar[i] += free;
      y_bar[i] = h * free;
    }
    S x_bar[kMostInputs] = {};
    eta_.template pullback<1>(theta + eta_begin(), x, tape, y_bar, theta_bar + eta_begin(), x_bar);
    see_pullback(theta, x, x_bar, theta_bar, in_bar, z_bar);
  }

  /// Torque at z = 0: sliding on, z need not settle anywhere.
  template <class S>
  void add_steady_torque(const S* theta, const Input<S>* in, S* tau_f) const {
    const S z[kLatents] = {S(0), S(0)};
    add_torque(theta, in, static_cast<const S*>(z), tau_f);
  }

 private:
  static constexpr int kMostInputs = 2 * kMostJoints + kLatents;
  using Net = Mlp<Activation::kMish, kAtRunTime, 2, kAtRunTime, kMostElements>;
  using Eta = Mlp<Activation::kMish, kAtRunTime, 1, kLatents, kMostElements>;

  // indices in theta
  constexpr int net_begin() const { return scales_.size(); }
  constexpr int eta_begin() const { return net_begin() + net_.weight_count(); }

  template <class S>
  void see(const S* theta, const Input<S>* in, const S* z, S* x) const {
    scales_.see(theta, in, x);
    for (int i = 0; i < kLatents; ++i) x[scales_.inputs() + i] = z[i];
  }
  template <class S>
  void see_pullback(const S* theta, const S* x, const S* x_bar, S* theta_bar, Input<S>* in_bar,
                    S* z_bar) const {
    scales_.see_pullback(theta, x, x_bar, theta_bar, in_bar);
    for (int i = 0; i < kLatents; ++i) z_bar[i] += x_bar[scales_.inputs() + i];
  }

  SignalScales scales_;
  Net net_;
  Eta eta_;
};

}  // namespace fricid::friction
