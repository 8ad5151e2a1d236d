// Input and output scales of networks of the whole robot: constants of the training data.
#pragma once

#include <vector>

#include "fricid/friction/elements.hpp"
#include "fricid/friction/law.hpp"

namespace fricid::friction {

/// The most joints that a law of the whole robot serves.
inline constexpr int kMostJoints = 8;

/// The first parameters of a law of the whole robot, all of them fixed: per joint the mean and the
/// standard deviation of position, and the root mean square of velocity and friction torque.
/// Inputs x and outputs y of its networks are of order one,
///
///     x = ((q - q_mean)/q_sd, v/v_sd)   (2 n),      tau_f = tau_sd y   (n).
class SignalScales {
 public:
  explicit constexpr SignalScales(int joints) : n_(joints) {}

  constexpr int joints() const { return n_; }
  constexpr int size() const { return 4 * n_; }
  constexpr int inputs() const { return 2 * n_; }
  /// Indices in theta.
  static constexpr int q_mean(int j) { return j; }
  constexpr int q_sd(int j) const { return n_ + j; }
  constexpr int v_sd(int j) const { return 2 * n_ + j; }
  constexpr int tau_sd(int j) const { return 3 * n_ + j; }

  template <class S>
  void see(const S* theta, const Input<S>* in, S* x) const {
    for (int j = 0; j < n_; ++j) {
      x[j] = (in[j].q - theta[q_mean(j)]) / theta[q_sd(j)];
      x[n_ + j] = in[j].v / theta[v_sd(j)];
    }
  }

  /// Vector-Jacobian product of `see`; x is its result.
  template <class S>
  void see_pullback(const S* theta, const S* x, const S* x_bar, S* theta_bar,
                    Input<S>* in_bar) const {
    for (int j = 0; j < n_; ++j) {
      const S q_bar = x_bar[j] / theta[q_sd(j)], v_bar = x_bar[n_ + j] / theta[v_sd(j)];
      in_bar[j].q += q_bar;
      in_bar[j].v += v_bar;
      theta_bar[q_mean(j)] -= q_bar;
      theta_bar[q_sd(j)] -= q_bar * x[j];
      theta_bar[v_sd(j)] -= v_bar * x[n_ + j];
    }
  }

  /// Adds tau_sd y to tau_f.
  template <class S>
  void say(const S* theta, const S* y, S* tau_f) const {
    for (int j = 0; j < n_; ++j) tau_f[j] += theta[tau_sd(j)] * y[j];
  }

  template <class S>
  void say_pullback(const S* theta, const S* y, const S* tau_f_bar, S* theta_bar, S* y_bar) const {
    for (int j = 0; j < n_; ++j) {
      theta_bar[tau_sd(j)] += tau_f_bar[j] * y[j];
      y_bar[j] = tau_f_bar[j] * theta[tau_sd(j)];
    }
  }

  void append_parameters(std::vector<ParameterInfo>& table) const {
    const auto rows = [&](auto symbol, const ParameterInfo& info) {
      for (int j = 0; j < n_; ++j) {
        table.push_back(info);
        table.back().symbol = symbol(j);
        table.back().element = j + 1;
      }
    };
    rows([](int j) { return numbered<"q_mean", kMostJoints>(j); },
         {"", "rad", Role::kPositionMean, -1e3, 1e3, 0, Scale::kFixed, "mean position"});
    rows([](int j) { return numbered<"q_sd", kMostJoints>(j); },
         {"", "rad", Role::kPositionScale, 1e-6, 1e3, 1, Scale::kFixed, "input scale: position"});
    rows([](int j) { return numbered<"v_sd", kMostJoints>(j); },
         {"", "rad/s", Role::kSpeedScale, 1e-6, 1e3, 1, Scale::kFixed, "input scale: velocity"});
    rows([](int j) { return numbered<"tau_sd", kMostJoints>(j); },
         {"", "N m", Role::kTorqueScale, 1e-6, 1e6, 5, Scale::kFixed,
          "output scale: friction torque"});
  }

 private:
  int n_;
};

/// Appends the table rows of `count` network weights, "w1" ..
inline void append_weights(int count, std::vector<ParameterInfo>& table) {
  for (int i = 0; i < count; ++i)
    table.push_back({numbered<"w", 9999>(i), "1", Role::kWeight, -100, 100, 0, Scale::kLinear,
                     "weight of a network", i + 1});
}

}  // namespace fricid::friction
