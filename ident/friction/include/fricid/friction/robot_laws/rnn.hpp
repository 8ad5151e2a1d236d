#pragma once

#include <string_view>
#include <vector>

#include "fricid/base/math.hpp"
#include "fricid/base/rng.hpp"
#include "fricid/friction/law.hpp"
#include "fricid/friction/recurrent.hpp"
#include "fricid/friction/signal_scales.hpp"

namespace fricid::friction {

/// One recurrent network for the friction of the whole robot: three recurrent layers of `elements`
/// ReLU units and a linear output,
///
///     tau_f = tau_sd o y(g(x, h)),    h <- g(x, h) once per sample,
///     x     = ((q - q_mean)/q_sd, v/v_sd).
///
/// The network is discrete in time: however finely the host steps, its memory h is updated when the
/// steps since the last update add up to one `sample`, with the motion at that time; a step longer
/// than a sample updates it once. The torque is evaluated at the present motion and h, not held
/// over the sample, since held friction would make a light joint chatter. In the host's scheme z is
/// updated with the new motion before the torque is read, so at a sample the network has the same
/// motion twice, in h and in x. State: h (3 x elements), then the elapsed share of a sample.
class Rnn {
 public:
  static constexpr std::string_view kName = "rnn";
  static constexpr std::string_view kEquation =
      "tau_f = tau_sd net(g(x, h)), h <- g(x, h) once per sample, x = ((q - q_mean)/q_sd, v/v_sd); "
      "three recurrent layers of `elements` ReLU units";
  static constexpr std::string_view kSource =
      "benchmark of Vantilborgh et al., Probabilistic latent variable modeling for dynamic "
      "friction identification and estimation, 2024";
  static constexpr PlotLook kLook{"#A0522D", 9};
  static constexpr int kMostElements = 32;
  static constexpr std::string_view kStateUnit = "1";

  /// @param size  1 .. kMostJoints joints, 1 .. kMostElements elements
  explicit constexpr Rnn(RobotLawSize size)
      : scales_(size.joints), net_(size.elements, scales_.inputs(), size.joints) {}

  constexpr int state_size() const { return net_.memory_size() + 1; }
  std::vector<ParameterInfo> parameters() const {
    std::vector<ParameterInfo> table;
    scales_.append_parameters(table);
    table.push_back({"sample", "s", Role::kSampleTime, 1e-6, 10, 4e-3, Scale::kFixed,
                     "time between two moves of h"});
    append_weights(net_.weight_count(), table);
    return table;
  }

  /// Random initial weights with a small output, so that friction starts near zero.
  void initialise(double* theta, Rng& rng) const {
    constexpr double kOutputScale = 0.01;
    net_.initialise(theta + net_begin(), rng, kOutputScale);
  }

  template <class S>
  void add_torque(const S* theta, const Input<S>* in, const S* z, S* tau_f) const {
    S x[2 * kMostJoints] = {}, g[kMostMemory] = {}, y[kMostJoints] = {};
    Net::Tape<S> tape;
    scales_.see(theta, in, x);
    net_.remember(theta + net_begin(), x, z, g, tape);
    net_.say(theta + net_begin(), g, y);
    scales_.say(theta, y, tau_f);
  }

  template <class S>
  void step(const S* theta, const Input<S>* in, double dt, S* z) const {
    S& passed = z[net_.memory_size()];
    const S now = passed + S(dt) / theta[sample()];
    const auto moves = now > S(1 - kSlack);
    passed = rest(now, moves);
    if (!any(moves)) return;
    S x[2 * kMostJoints] = {}, g[kMostMemory] = {};
    Net::Tape<S> tape;
    scales_.see(theta, in, x);
    net_.remember(theta + net_begin(), x, z, g, tape);
    for (int i = 0; i < net_.memory_size(); ++i) z[i] = select(moves, min(S(kMost), g[i]), z[i]);
  }

  template <class S>
  void torque_pullback(const S* theta, const Input<S>* in, const S* z, const S* tau_f_bar,
                       S* theta_bar, Input<S>* in_bar, S* z_bar) const {
    S x[2 * kMostJoints] = {}, g[kMostMemory] = {}, y[kMostJoints] = {};
    Net::Tape<S> tape;
    scales_.see(theta, in, x);
    net_.remember(theta + net_begin(), x, z, g, tape);
    net_.say(theta + net_begin(), g, y);
    S y_bar[kMostJoints] = {}, g_bar[kMostMemory] = {}, x_bar[2 * kMostJoints] = {};
    scales_.say_pullback(theta, y, tau_f_bar, theta_bar, y_bar);
    net_.say_pullback(theta + net_begin(), g, y_bar, theta_bar + net_begin(), g_bar);
    net_.remember_pullback(theta + net_begin(), tape, g_bar, theta_bar + net_begin(), x_bar, z_bar);
    scales_.see_pullback(theta, x, x_bar, theta_bar, in_bar);
  }

  template <class S>
  void step_pullback(const S* theta, const Input<S>* in, double dt, const S* z, const S* z_next_bar,
                     S* theta_bar, Input<S>* in_bar, S* z_bar) const {
    const int size = net_.memory_size();
    const S now = z[size] + S(dt) / theta[sample()];
    const auto moves = now > S(1 - kSlack);
    // a remainder rounded to 0 has no derivative
    const S now_bar =
        select(moves, select(rest(now, moves) == S(0), S(0), z_next_bar[size]), z_next_bar[size]);
    z_bar[size] += now_bar;
    theta_bar[sample()] -= now_bar * S(dt) / (theta[sample()] * theta[sample()]);
    for (int i = 0; i < size; ++i) z_bar[i] += select(moves, S(0), z_next_bar[i]);
    if (!any(moves)) return;
    S x[2 * kMostJoints] = {}, g[kMostMemory] = {};
    Net::Tape<S> tape;
    scales_.see(theta, in, x);
    net_.remember(theta + net_begin(), x, z, g, tape);
    S g_bar[kMostMemory] = {}, x_bar[2 * kMostJoints] = {};
    for (int i = 0; i < size; ++i)
      g_bar[i] = select(moves, select(g[i] < S(kMost), z_next_bar[i], S(0)), S(0));
    net_.remember_pullback(theta + net_begin(), tape, g_bar, theta_bar + net_begin(), x_bar, z_bar);
    scales_.see_pullback(theta, x, x_bar, theta_bar, in_bar);
  }

  /// Torque after 100 samples at the same input.
  template <class S>
  void add_steady_torque(const S* theta, const Input<S>* in, S* tau_f) const {
    constexpr int kSamples = 100;
    S x[2 * kMostJoints] = {}, h[kMostMemory] = {}, g[kMostMemory] = {}, y[kMostJoints] = {};
    Net::Tape<S> tape;
    scales_.see(theta, in, x);
    for (int k = 0; k < kSamples; ++k) {
      net_.remember(theta + net_begin(), x, static_cast<const S*>(h), g, tape);
      for (int i = 0; i < net_.memory_size(); ++i) h[i] = min(S(kMost), g[i]);
    }
    net_.say(theta + net_begin(), static_cast<const S*>(g), y);
    scales_.say(theta, y, tau_f);
  }

 private:
  static constexpr int kLayers = 3;
  static constexpr int kMostMemory = kLayers * kMostElements;
  static constexpr double kSlack = 1e-3;  // share of a sample that rounding may lose or add
  static constexpr double kMost = 1e3;    // largest memory of a unit
  using Net = RecurrentNet<Activation::kRelu, kLayers, kMostElements, 2 * kMostJoints>;

  // indices in theta
  constexpr int sample() const { return scales_.size(); }
  constexpr int net_begin() const { return sample() + 1; }

  /// Elapsed share of a sample after a step, without whole further samples and rounding.
  template <class S, class Mask>
  static S rest(const S& now, const Mask& moves) {
    const S over = now - S(1);
    return select(moves, select(over < S(kSlack), S(0), select(over < S(1), over, S(0))), now);
  }

  SignalScales scales_;
  Net net_;
};

}  // namespace fricid::friction
