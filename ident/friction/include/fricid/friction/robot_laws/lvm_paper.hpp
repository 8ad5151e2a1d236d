#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <string_view>
#include <vector>

#include "fricid/base/math.hpp"
#include "fricid/base/rng.hpp"
#include "fricid/friction/law.hpp"
#include "fricid/friction/mlp.hpp"
#include "fricid/friction/signal_scales.hpp"

namespace fricid::friction {

/// The latent-variable model as published: one network gives the friction torque of the whole
/// robot, another the rates of its latent states, both from all positions, velocities and latents,
///
///     x = ((q - q_mean)/q_sd, v/v_sd, z),    tau_f = tau_sd o y(x),    dz/dt = 300/s eta(x'),
///
/// x' being x with v_j/(300/s l_j) in the place of v_j/v_sd: the length l_j says over which travel
/// the latents of joint j change.
/// y has two hidden layers of `elements` Mish units, eta one. `step` is an explicit Euler step that
/// clamps |z_i| to kMost, since eta alone does not bound z. State: z (latents).
///
/// The networks start where they can be trained. Latent i follows the speed of joint j = i mod n
/// between two stops, which takes four units,
///
///     eta_i = clamp(u, -1 - z_i, 1 - z_i),     u = v_j / (300/s l_j),
///
/// with l_j = 2 mrad from rest to stop for the first n latents, three times as much for every
/// further n. Every unit of the torque's network sees one joint, its latents and its speed on
/// scales from .03 rad/s up; its output is zero. Weights between joints and on positions start at
/// zero. With cross = 0 they stay there: they do not act, are not read and have no gradient, which
/// makes the networks several times cheaper.
class LvmPaper {
 public:
  static constexpr std::string_view kName = "lvm_paper";
  static constexpr std::string_view kEquation =
      "tau_f = tau_sd net((q - q_mean)/q_sd, v/v_sd, z), "
      "dz/dt = 300/s eta((q - q_mean)/q_sd, v/(300/s l), z), |z| <= 10; "
      "net has two hidden layers of `elements` Mish units, eta one; n_z latents";
  static constexpr std::string_view kSource =
      "Vantilborgh et al., Probabilistic latent variable modeling for dynamic friction "
      "identification and estimation, 2024";
  static constexpr PlotLook kLook{"#4169E1", 4};
  static constexpr int kMostElements = 32;
  static constexpr int kMostLatents = 12;
  static constexpr std::string_view kStateUnit = "1";
  static constexpr double kRate = 300;  ///< of z where eta is 1 [1/s]
  static constexpr double kMost = 10;   ///< largest |z_i|

  /// @param size  1 .. kMostJoints joints, 1 .. kMostElements elements, 1 .. kMostLatents latents
  explicit constexpr LvmPaper(RobotLawSize size)
      : scales_(size.joints),
        latents_(size.latents),
        net_(size.elements, scales_.inputs() + latents_, size.joints),
        eta_(size.elements, scales_.inputs() + latents_, latents_) {}

  constexpr int state_size() const { return latents_; }
  std::vector<ParameterInfo> parameters() const {
    std::vector<ParameterInfo> table;
    scales_.append_parameters(table);
    for (int j = 0; j < scales_.joints(); ++j)
      table.push_back({numbered<"l", kMostJoints>(j), "rad", Role::kLength, 1e-6, 1, 2e-3,
                       j < latents_ ? Scale::kLog : Scale::kFixed,
                       "travel over which the latents of a joint change", j + 1});
    table.push_back({"cross", "1", Role::kCrossWeights, 0, 1, 0, Scale::kFixed,
                     "1: weights between joints and on positions act; 0: they are zero"});
    append_weights(net_.weight_count() + eta_.weight_count(), table);
    return table;
  }

  /// Writes the initial weights; the scales must be set before.
  void initialise(double* theta, Rng& rng) const;

  /// Rate of every weight: its size at the start within bounds, 1 if it starts at zero; for
  /// weights between joints and on positions the least of these, without cross 0.
  void training_rates(const double* theta, double* rate) const;

  template <class S>
  void add_torque(const S* theta, const Input<S>* in, const S* z, S* tau_f) const {
    S x[kMostInputs] = {}, y[kMostJoints] = {};
    see(theta, in, z, x);
    with_wiring(theta, net_wiring(), [&](const auto& wiring) {
      net_.template forward<1>(theta + net_begin(), x, y, wiring);
    });
    scales_.say(theta, y, tau_f);
  }

  template <class S>
  void step(const S* theta, const Input<S>* in, double dt, S* z) const {
    S x[kMostInputs] = {}, y[kMostLatents] = {};
    see_travel(theta, in, z, x);
    with_wiring(theta, eta_wiring(), [&](const auto& wiring) {
      eta_.template forward<1>(theta + eta_begin(), x, y, wiring);
    });
    for (int i = 0; i < latents_; ++i)
      z[i] = max(S(-kMost), min(S(kMost), z[i] + S(dt) * (S(kRate) * y[i])));
  }

  template <class S>
  void torque_pullback(const S* theta, const Input<S>* in, const S* z, const S* tau_f_bar,
                       S* theta_bar, Input<S>* in_bar, S* z_bar) const {
    S x[kMostInputs] = {}, y[kMostJoints] = {}, y_bar[kMostJoints] = {};
    Net::Tape<1, S> tape;
    see(theta, in, z, x);
    S x_bar[kMostInputs] = {};
    with_wiring(theta, net_wiring(), [&](const auto& wiring) {
      net_.template forward<1>(theta + net_begin(), x, y, tape, wiring);
      scales_.say_pullback(theta, y, tau_f_bar, theta_bar, y_bar);
      net_.template pullback<1>(theta + net_begin(), x, tape, y_bar, theta_bar + net_begin(), x_bar,
                                wiring);
    });
    see_pullback(theta, x, x_bar, theta_bar, in_bar, z_bar);
  }

  template <class S>
  void step_pullback(const S* theta, const Input<S>* in, double dt, const S* z, const S* z_next_bar,
                     S* theta_bar, Input<S>* in_bar, S* z_bar) const {
    S x[kMostInputs] = {}, y[kMostLatents] = {}, y_bar[kMostLatents] = {};
    Eta::Tape<1, S> tape;
    see_travel(theta, in, z, x);
    S x_bar[kMostInputs] = {};
    with_wiring(theta, eta_wiring(), [&](const auto& wiring) {
      eta_.template forward<1>(theta + eta_begin(), x, y, tape, wiring);
      const S h = S(kRate) * S(dt);
      for (int i = 0; i < latents_; ++i) {
        const S free = select(abs(z[i] + h * y[i]) < S(kMost), z_next_bar[i], S(0));
        z_bar[i] += free;
        y_bar[i] = h * free;
      }
      eta_.template pullback<1>(theta + eta_begin(), x, tape, y_bar, theta_bar + eta_begin(), x_bar,
                                wiring);
    });
    for (int j = 0; j < scales_.joints(); ++j) {
      S& u_bar = x_bar[scales_.joints() + j];
      in_bar[j].v += u_bar / (S(kRate) * theta[length(j)]);
      theta_bar[length(j)] -= u_bar * x[scales_.joints() + j] / theta[length(j)];
      u_bar = S(0);
    }
    see_pullback(theta, x, x_bar, theta_bar, in_bar, z_bar);
  }

  /// Torque at z = 0: z need not converge at constant v.
  template <class S>
  void add_steady_torque(const S* theta, const Input<S>* in, S* tau_f) const {
    const S z[kMostLatents] = {};
    add_torque(theta, in, static_cast<const S*>(z), tau_f);
  }

 private:
  static constexpr int kMostInputs = 2 * kMostJoints + kMostLatents;
  using Net = Mlp<Activation::kMish, kAtRunTime, 2, kAtRunTime, kMostElements>;
  using Eta = Mlp<Activation::kMish, kAtRunTime, 1, kAtRunTime, kMostElements>;

  // indices in theta
  constexpr int length(int joint) const { return scales_.size() + joint; }
  constexpr int cross() const { return length(scales_.joints()); }
  constexpr int net_begin() const { return cross() + 1; }
  constexpr int eta_begin() const { return net_begin() + net_.weight_count(); }

  template <class S>
  void see(const S* theta, const Input<S>* in, const S* z, S* x) const {
    scales_.see(theta, in, x);
    for (int i = 0; i < latents_; ++i) x[scales_.inputs() + i] = z[i];
  }
  /// Inputs of eta.
  template <class S>
  void see_travel(const S* theta, const Input<S>* in, const S* z, S* x) const {
    see(theta, in, z, x);
    for (int j = 0; j < scales_.joints(); ++j)
      x[scales_.joints() + j] = in[j].v / (S(kRate) * theta[length(j)]);
  }
  template <class S>
  void see_pullback(const S* theta, const S* x, const S* x_bar, S* theta_bar, Input<S>* in_bar,
                    S* z_bar) const {
    scales_.see_pullback(theta, x, x_bar, theta_bar, in_bar);
    for (int i = 0; i < latents_; ++i) z_bar[i] += x_bar[scales_.inputs() + i];
  }

  /// Joint that a unit or a latent belongs to.
  constexpr int joint_of(int index) const { return index % scales_.joints(); }
  /// Joint whose speed or latent an input is; -1 for positions.
  constexpr int joint_seen(int input) const {
    const int n = scales_.joints();
    return input < n ? -1 : input < 2 * n ? input - n : joint_of(input - 2 * n);
  }
  /// Use of the units of eta: first those of u, two per joint that has latents, or one if there
  /// are too few; then two per latent for its stops; the rest is spare.
  struct RateUnits {
    int joints, per_joint, stopped;
  };
  constexpr RateUnits rate_units() const {
    const int joints = std::min(scales_.joints(), latents_), width = eta_.width();
    const int per_joint = 2 * (joints + latents_) <= width ? 2 : 1;
    const int stopped = std::clamp((width - per_joint * joints) / 2, 0, latents_);
    return {stopped > 0 ? joints : 0, per_joint, stopped};
  }

  /// Joint of every unit of a network.
  using UnitJoints = std::array<int, kMostElements>;
  constexpr UnitJoints net_units() const {
    UnitJoints of{};
    int j = 0;
    for (int& joint : of) {
      joint = j;
      j = j + 1 == scales_.joints() ? 0 : j + 1;
    }
    return of;
  }
  constexpr UnitJoints eta_units() const {
    UnitJoints of{};
    const RateUnits units = rate_units();
    std::size_t u = 0;
    for (int j = 0; j < units.joints; ++j)
      for (int k = 0; k < units.per_joint; ++k) of[u++] = j;
    // of `of_each` units for every latent, until `count` are there
    const auto by_latents = [&](int of_each, int count) {
      for (int i = 0, j = 0, k = 0; k < count; ++k) {
        of[u++] = j;
        if ((k + 1) % of_each > 0) continue;
        i = i + 1 == latents_ ? 0 : i + 1;
        j = i == 0 || j + 1 == scales_.joints() ? 0 : j + 1;
      }
    };
    by_latents(2, 2 * units.stopped);
    by_latents(1, eta_.width() - static_cast<int>(u));
    return of;
  }

  /// Layers without the weights between joints and on positions: inputs are n positions, then n
  /// speeds and the latents, each those of joints 0, 1, ...
  struct WithinJoints {
    int n;
    UnitJoints of;

    /// First input, behind `begin`, of the joint of a unit.
    auto first(int begin) const {
      return [this, begin](int unit) { return begin + of[static_cast<std::size_t>(unit)]; };
    }
  };
  struct NetWiring : WithinJoints {
    template <int kColumns, class S>
    void layer(int l, int inputs, int outputs, const S* layer, const S* x, S* y) const {
      sparse_rows(inputs, outputs, n, first(l == 0 ? n : 0), layer, x, y);
    }
    template <int kColumns, class S>
    void layer_pullback(int l, int inputs, int outputs, const S* layer, const S* x, const S* y_bar,
                        S* layer_bar, S* x_bar) const {
      sparse_rows_pullback(inputs, outputs, n, first(l == 0 ? n : 0), layer, x, y_bar, layer_bar,
                           x_bar);
    }
  };
  struct EtaWiring : WithinJoints {
    template <int kColumns, class S>
    void layer(int l, int inputs, int outputs, const S* layer, const S* x, S* y) const {
      if (l == 0)
        sparse_rows(inputs, outputs, n, first(n), layer, x, y);
      else
        sparse_columns(inputs, outputs, n, first(0), layer, x, y);
    }
    template <int kColumns, class S>
    void layer_pullback(int l, int inputs, int outputs, const S* layer, const S* x, const S* y_bar,
                        S* layer_bar, S* x_bar) const {
      if (l == 0)
        sparse_rows_pullback(inputs, outputs, n, first(n), layer, x, y_bar, layer_bar, x_bar);
      else
        sparse_columns_pullback(inputs, outputs, n, first(0), layer, x, y_bar, layer_bar, x_bar);
    }
  };
  constexpr NetWiring net_wiring() const { return {{scales_.joints(), net_units()}}; }
  constexpr EtaWiring eta_wiring() const { return {{scales_.joints(), eta_units()}}; }

  /// Calls f(wiring) with the layers that theta asks for.
  template <class S, class F>
  void with_wiring(const S* theta, const auto& within_joints, F&& f) const {
    if (any(theta[cross()] > S(0)))
      f(Dense{});
    else
      f(within_joints);
  }

  void start_torque(double* theta, Rng& rng) const;
  void start_rate(double* theta, Rng& rng) const;

  SignalScales scales_;
  int latents_;
  Net net_;
  Eta eta_;
};

}  // namespace fricid::friction
