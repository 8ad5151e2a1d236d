#pragma once

#include <string_view>
#include <vector>

#include "fricid/base/math.hpp"
#include "fricid/base/rng.hpp"
#include "fricid/friction/law.hpp"
#include "fricid/friction/mlp.hpp"
#include "fricid/friction/signal_scales.hpp"

namespace fricid::friction {

/// One network without memory for the friction of the whole robot:
///
///     tau_f = tau_sd o y(x),   x = ((q - q_mean)/q_sd, v/v_sd)
///
/// y has two hidden layers of `elements` ReLU units. It is neither odd in v nor dissipative by
/// construction, and arbitrary outside the range of the training data. No state.
class Nn {
 public:
  static constexpr std::string_view kName = "nn";
  static constexpr std::string_view kEquation =
      "tau_f = tau_sd net((q - q_mean)/q_sd, v/v_sd), two hidden layers of `elements` ReLU units";
  static constexpr std::string_view kSource =
      "benchmark of Vantilborgh et al., Probabilistic latent variable modeling for dynamic "
      "friction identification and estimation, 2024";
  static constexpr PlotLook kLook{"#B8860B", 6};
  static constexpr int kMostElements = 32;

  /// @param size  1 .. kMostJoints joints, 1 .. kMostElements elements
  explicit constexpr Nn(RobotLawSize size)
      : scales_(size.joints), net_(size.elements, scales_.inputs(), size.joints) {}

  static constexpr int state_size() { return 0; }
  std::vector<ParameterInfo> parameters() const {
    std::vector<ParameterInfo> table;
    scales_.append_parameters(table);
    append_weights(net_.weight_count(), table);
    return table;
  }

  /// Random initial weights with a small output, so that friction starts near zero.
  void initialise(double* theta, Rng& rng) const {
    constexpr double kOutputScale = 0.01;
    net_.initialise(theta + scales_.size(), rng, kOutputScale);
  }

  template <class S>
  void add_torque(const S* theta, const Input<S>* in, const S*, S* tau_f) const {
    S x[2 * kMostJoints] = {}, y[kMostJoints] = {};
    scales_.see(theta, in, x);
    net_.template forward<1>(theta + scales_.size(), x, y);
    scales_.say(theta, y, tau_f);
  }

  template <class S>
  void step(const S*, const Input<S>*, double, S*) const {}

  template <class S>
  void torque_pullback(const S* theta, const Input<S>* in, const S*, const S* tau_f_bar,
                       S* theta_bar, Input<S>* in_bar, S*) const {
    S x[2 * kMostJoints] = {}, y[kMostJoints] = {}, x_bar[2 * kMostJoints] = {},
            y_bar[kMostJoints] = {};
    Net::Tape<1, S> tape;
    scales_.see(theta, in, x);
    net_.template forward<1>(theta + scales_.size(), x, y, tape);
    scales_.say_pullback(theta, y, tau_f_bar, theta_bar, y_bar);
    net_.template pullback<1>(theta + scales_.size(), x, tape, y_bar, theta_bar + scales_.size(),
                              x_bar);
    scales_.see_pullback(theta, x, x_bar, theta_bar, in_bar);
  }

  template <class S>
  void step_pullback(const S*, const Input<S>*, double, const S*, const S*, S*, Input<S>*,
                     S*) const {}

  template <class S>
  void add_steady_torque(const S* theta, const Input<S>* in, S* tau_f) const {
    add_torque(theta, in, static_cast<const S*>(nullptr), tau_f);
  }

 private:
  using Net = Mlp<Activation::kRelu, kAtRunTime, 2, kAtRunTime, kMostElements>;

  SignalScales scales_;
  Net net_;
};

}  // namespace fricid::friction
