#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <string_view>

#include "fricid/base/math.hpp"
#include "fricid/base/rng.hpp"
#include "fricid/friction/elements.hpp"
#include "fricid/friction/law.hpp"
#include "fricid/friction/mlp.hpp"

namespace fricid::friction {

/// A small network on what a joint remembers, for friction that no other law describes:
///
///     z_i' = clamp(z_i + v dt/l_i, -1, 1), i = 1 .. 4      travel since a reversal
///     s'   = v + (s - v) exp(-dt/T)                        speed that lags by T
///     tau  = Fn net(z, tanh(s/v_1), tanh(s/v_2), tanh(s/v_3))
///
/// The network has one layer of `elements` tanh units. Its inputs are odd functions of the motion
/// and it has no biases, so tau is odd without a second evaluation; it is not dissipative. With
/// output weights of zero, as it starts, it adds nothing. `step` is exact for held v; v = 0 keeps
/// the state. State: z_1 .. z_4, s/v_3.
class MemoryNetwork {
 public:
  static constexpr int kStops = 4, kSpeeds = 3;
  enum Index { kFn, kV1, kLag = kV1 + kSpeeds, kLength, kCommon = kLength + kStops };

  static constexpr std::string_view kName = "memory_network";
  static constexpr std::string_view kEquation =
      "z_i' = clamp(z_i + v dt/l_i, +-1), i = 1 .. 4; ds/dt = (v - s)/T; tau = Fn net(z, "
      "tanh(s/v_k)), k = 1 .. 3, one layer of `elements` tanh units without biases";
  static constexpr std::string_view kSource =
      "stops as the memory of a network: Serpico & Visone, IEEE Trans. Magnetics 34(3), 1998";
  static constexpr PlotLook kLook{"#5E4FA2", 4};
  static constexpr Claims kClaims{.dissipative = false};
  static constexpr Reads kReads{};
  static constexpr int kMostElements = 8;
  static constexpr std::string_view kStateUnit = "1";

  /// @param elements  units, 1 .. kMostElements
  explicit constexpr MemoryNetwork(int elements) : net_(elements) {}

  static constexpr int state_size() { return kStops + 1; }
  constexpr std::span<const ParameterInfo> parameters() const {
    return std::span(kTables[static_cast<std::size_t>(net_.width())])
        .first(static_cast<std::size_t>(kCommon + net_.weight_count()));
  }

  /// Random units, from nearly linear ones to such as saturate; no output.
  void initialise(double* theta, Rng& rng) const {
    constexpr double kNoOutput = 0, kSteepest = 5;
    net_.initialise(theta + kCommon, rng, kNoOutput);
    const int units = net_.width();
    for (int u = 0; u < units; ++u)
      for (int i = 0; i < kInputs; ++i)
        theta[kCommon + u * kInputs + i] *= std::pow(kSteepest, u / std::max(1.0, units - 1.0));
  }

  template <class S>
  S torque(const S* theta, const Input<S>&, const S* z) const {
    S x[kInputs], y;
    inputs(theta, z, x);
    net_.template forward<1>(theta + kCommon, x, &y);
    return theta[kFn] * y;
  }

  template <class S>
  void step(const S* theta, const Input<S>& in, double dt, S* z) const {
    for (int i = 0; i < kStops; ++i)
      z[i] = clamp(z[i] + in.v * S(dt) / theta[kLength + i], S(-1), S(1));
    // s + (v - s) (1 - e^-x): dt = 0 keeps the state to the last bit
    S& s = z[kStops];
    const S next = s + (s - in.v / theta[kFastest]) * expm1(-(S(dt) / theta[kLag]));
    s = select(in.v == S(0), s, next);
  }

  template <class S>
  void torque_pullback(const S* theta, const Input<S>&, const S* z, const S& tau_bar, S* theta_bar,
                       Input<S>&, S* z_bar) const {
    S x[kInputs], x_bar[kInputs], y;
    inputs(theta, z, x);
    Net::template Tape<1, S> tape;
    net_.template forward<1>(theta + kCommon, x, &y, tape);
    theta_bar[kFn] += tau_bar * y;
    const S y_bar = tau_bar * theta[kFn];
    for (S& bar : x_bar) bar = S(0);
    net_.template pullback<1>(theta + kCommon, x, tape, &y_bar, theta_bar + kCommon, x_bar);
    const S s = z[kStops] * theta[kFastest];
    S s_bar = S(0);
    for (int i = 0; i < kStops; ++i) z_bar[i] += x_bar[i];
    for (int k = 0; k < kSpeeds; ++k) {
      const S& t = x[kStops + k];
      const S own_bar = x_bar[kStops + k] * (S(1) - t * t) / theta[kV1 + k];
      s_bar += own_bar;
      theta_bar[kV1 + k] -= own_bar * s / theta[kV1 + k];
    }
    z_bar[kStops] += s_bar * theta[kFastest];
    theta_bar[kFastest] += s_bar * z[kStops];
  }

  template <class S>
  void step_pullback(const S* theta, const Input<S>& in, double dt, const S* z, const S* z_next_bar,
                     S* theta_bar, Input<S>& in_bar, S* z_bar) const {
    for (int i = 0; i < kStops; ++i) {
      const S per_length = S(dt) / theta[kLength + i];
      const S bar = select(abs(z[i] + in.v * per_length) < S(1), z_next_bar[i], S(0));
      z_bar[i] += bar;
      in_bar.v += bar * per_length;
      theta_bar[kLength + i] -= bar * in.v * per_length / theta[kLength + i];
    }
    const Settling<S> lag(theta, in.v, dt);
    const S bar = z_next_bar[kStops], inverse = S(1) / theta[kFastest];
    const S to = in.v * inverse, to_bar = bar * lag.settled;
    z_bar[kStops] += bar * (S(1) - lag.settled);
    in_bar.v += to_bar * inverse;
    theta_bar[kFastest] -= to_bar * to * inverse;
    theta_bar[kLag] += bar * (to - z[kStops]) * lag.by_T;
  }

  /// dz_i/dl_i and ds/dT; v_3 only scales the state.
  static constexpr int tangent_size() { return kStops + 1; }

  template <class S>
  void step_tangent(const S* theta, const Input<S>& in, double dt, const S* z, S* T) const {
    for (int i = 0; i < kStops; ++i) {
      const S per_length = S(dt) / theta[kLength + i];
      const auto moves = abs(z[i] + in.v * per_length) < S(1);
      T[i] = select(moves, T[i] - in.v * per_length / theta[kLength + i], S(0));
    }
    const Settling<S> lag(theta, in.v, dt);
    T[kStops] = T[kStops] * (S(1) - lag.settled) + (in.v / theta[kFastest] - z[kStops]) * lag.by_T;
  }

  template <class S>
  void add_tangent(const S*, const S* z_bar, const S* T, S* theta_bar) const {
    for (int i = 0; i < kStops; ++i) theta_bar[kLength + i] += z_bar[i] * T[i];
    theta_bar[kLag] += z_bar[kStops] * T[kStops];
  }

  /// v = 0 returns 0.
  template <class S>
  S steady_torque(const S* theta, const Input<S>& in) const {
    S z[kStops + 1];
    for (int i = 0; i < kStops; ++i) z[i] = sign(in.v);
    z[kStops] = in.v / theta[kFastest];
    return torque<S>(theta, in, z);
  }

  void state_bound(const double* theta, double fastest, double* bound) const {
    for (int i = 0; i < kStops; ++i) bound[i] = 1;
    bound[kStops] = fastest / theta[kFastest];
  }

 private:
  static constexpr int kFastest = kV1 + kSpeeds - 1, kInputs = kStops + kSpeeds;
  using Net = Mlp<Activation::kTanh, kInputs, 1, 1, kMostElements>;

  template <class S>
  static void inputs(const S* theta, const S* z, S* x) {
    const S s = z[kStops] * theta[kFastest];
    for (int i = 0; i < kStops; ++i) x[i] = z[i];
    for (int k = 0; k < kSpeeds; ++k) x[kStops + k] = tanh(s / theta[kV1 + k]);
  }

  /// Share by which s settles in a step, 1 - exp(-dt/T), and its derivative by T; both 0 at rest.
  template <class S>
  struct Settling {
    S settled, by_T;
    Settling(const S* theta, const S& v, double dt) {
      const auto rests = v == S(0);
      const S x = S(dt) / theta[kLag], share = -expm1(-x);
      settled = select(rests, S(0), share);
      by_T = select(rests, S(0), -(S(1) - share) * x / theta[kLag]);
    }
  };

  static constexpr auto kTables = [] {
    constexpr double kLengths[kStops] = {2e-4, 7e-4, 2.5e-3, 7e-3};
    constexpr double kScales[kSpeeds] = {0.02, 0.2, 2};
    constexpr int kWeights = Net(kMostElements).weight_count();
    std::array<ParameterInfo, kCommon> common{{
        {"Fn", "N m", Role::kNetworkTorque, 1e-6, 1e6, 5, Scale::kFixed,
         "size of the network's torque"},
    }};
    for (int k = 0; k < kSpeeds; ++k)
      common[static_cast<std::size_t>(kV1 + k)] = {
          numbered<"v">(k), "rad/s",       Role::kSaturationSpeed, 1e-4, 1e2,
          kScales[k],       Scale::kFixed, "input scale: speed",   k + 1};
    common[kLag] = {"T", "s", Role::kLag, 1e-4, 0.1, 5e-3, Scale::kLog, "lag of the speed"};
    for (int i = 0; i < kStops; ++i)
      common[static_cast<std::size_t>(kLength + i)] = {
          numbered<"l">(i), "rad",       Role::kLength,          1e-5, 0.1,
          kLengths[i],      Scale::kLog, "length of the memory", i + 1};
    std::array<std::array<ParameterInfo, kCommon + kWeights>, kMostElements + 1> tables{};
    for (int units = 1; units <= kMostElements; ++units) {
      auto& table = tables[static_cast<std::size_t>(units)];
      table = weight_table<kWeights>(common);
      // biases, after the weights of each layer
      const auto hold = [&](int w) {
        ParameterInfo& bias = table[static_cast<std::size_t>(kCommon + w)];
        bias.lower = bias.upper = 0;
        bias.scale = Scale::kFixed;
        bias.meaning = "bias of an odd network";
      };
      for (int u = 0; u < units; ++u) {
        hold(kInputs * units + u);
        table[static_cast<std::size_t>(kCommon + (kInputs + 1) * units + u)].role =
            Role::kOutputWeight;
      }
      hold(Net(units).weight_count() - 1);
    }
    return tables;
  }();

  Net net_;
};

}  // namespace fricid::friction
