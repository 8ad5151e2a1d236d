#pragma once

#include <array>
#include <cmath>
#include <span>
#include <string_view>

#include "fricid/base/math.hpp"
#include "fricid/base/rng.hpp"
#include "fricid/friction/bristle.hpp"
#include "fricid/friction/elements.hpp"
#include "fricid/friction/law.hpp"
#include "fricid/friction/mlp.hpp"
#include "fricid/friction/net_inputs.hpp"

namespace fricid::friction {

/// Latent-variable model of one joint: bristles whose torque and rate are corrected by networks.
/// With L dimensionless latents s_i and the input x = (v/v_ref, tanh(v/v1), tanh(v/v2), s_1 .. s_L,
/// |load|/load_ref),
///
///     tau    = F0 tanh(v/v0) + Fv v + (sum_i K_i s_i) (1 + n1(x)) + Fc n0(x)
///     ds_i/dt = (v - rho_i |v| s_i) / Delta_i,   rho_i = exp(3 tanh(r_i/3))
///
/// (n0, n1) come from one network y(x), two hidden layers of `elements` Mish units, made odd and
/// even by evaluating it at the mirrored input x~ too (all of x negated but |load|):
///
///     n0 = y_0(x) - y_0(x~),   n1 = y_1(x) + y_1(x~),   so that   tau(-v, -s) = -tau(v, s).
///
/// r_i is a network of its own, one hidden layer of kRateWidth Mish units, with inputs in the
/// direction of sliding: (|v|/v_ref, tanh(|v|/v1), tanh(|v|/v2), sgn(v) s_i, |load|/load_ref).
///
/// While the joint slides every latent falls towards sgn(v)/rho_i, |s_i| <= e^3; at v = 0 it keeps
/// its value. `step` holds rho_i over the step and is exact in the rest, so two half steps equal
/// one only where rho_i does not depend on s_i. The networks are not dissipative by construction.
/// With all weights zero the law is L Dahl bristles of level K_i and length Delta_i with Coulomb
/// and viscous friction. State: s_i (L).
template <int kLatents>
class BasicLvm {
 public:
  enum Index { kF0, kV0, kFv, kFc, kScales, kBristles = kScales + NetInputs<double>::kSize };
  static constexpr int kCommon = kBristles + 2 * kLatents;

  static constexpr std::string_view kName = kLatents == 1   ? "lvm1"
                                            : kLatents == 2 ? "lvm_bristles"
                                                            : "lvm4";
  static constexpr std::string_view kEquation =
      "ds_i/dt = (v - rho_i |v| s_i)/Delta_i, rho_i = net_i(|v|, sgn(v) s_i, |load|) in e^-3 .. "
      "e^3; tau = F0 tanh(v/v0) + Fv v + sum K_i s_i (1 + n1) + Fc n0, (n0 odd, n1 even) = net(v, "
      "s, |load|), two hidden layers of `elements` units";
  static constexpr std::string_view kSource =
      "latent states as Vantilborgh et al., Probabilistic latent variable modeling for dynamic "
      "friction identification and estimation, 2024, on bristles as Dahl, AIAA Journal 14(12), "
      "1976";
  static constexpr PlotLook kLook = kLatents == 1   ? PlotLook{"#5D3FD3", 12}
                                    : kLatents == 2 ? PlotLook{"#0072B2", 15}
                                                    : PlotLook{"#00446B", 14};
  static constexpr Claims kClaims{
      .dissipative = false, .contracts = false, .semigroup = false, .settles = false};
  static constexpr Reads kReads{.load = true};
  static constexpr int kMostElements = 32;
  static constexpr std::string_view kStateUnit = "1";
  static constexpr int kRateWidth = 8;
  static constexpr double kLogRateLimit = 3;  ///< |log rho| < this

  /// @param elements  width of the hidden layers of the torque network, 1 .. kMostElements
  explicit constexpr BasicLvm(int elements) : net_(elements) {}

  static constexpr int state_size() { return kLatents; }
  constexpr std::span<const ParameterInfo> parameters() const {
    return std::span(kTable).first(static_cast<std::size_t>(rate_begin(kLatents)));
  }
  /// Indices in theta.
  static constexpr int K(int i) { return kBristles + 2 * i; }
  static constexpr int delta(int i) { return kBristles + 2 * i + 1; }

  /// Random initial weights with small outputs, so that the law starts as its bristles.
  void initialise(double* theta, Rng& rng) const {
    constexpr double kOutputScale = 0.01;
    net_.initialise(theta + kCommon, rng, kOutputScale);
    for (int i = 0; i < kLatents; ++i)
      kRateNet.initialise(theta + rate_begin(i), rng, kOutputScale);
  }

  template <class S>
  S torque(const S* theta, const Input<S>& in, const S* s) const {
    return torque_of(theta, in, NetInputs<S>::of(theta + kScales, in.v, in.load), s);
  }

  template <class S>
  void step(const S* theta, const Input<S>& in, double dt, S* s) const {
    step_by(theta, in, NetInputs<S>::of(theta + kScales, abs(in.v), in.load), dt, s);
  }

  template <class S>
  S step_torque(const S* theta, const Input<S>& in, double dt, S* s) const {
    const NetInputs<S> features = NetInputs<S>::of(theta + kScales, in.v, in.load);
    step_by(theta, in, features.ahead(), dt, s);
    return torque_of(theta, in, features, static_cast<const S*>(s));
  }

  template <class S>
  void torque_pullback(const S* theta, const Input<S>& in, const S* s, const S& tau_bar,
                       S* theta_bar, Input<S>& in_bar, S* s_bar) const {
    const NetInputs<S> features = NetInputs<S>::of(theta + kScales, in.v, in.load);
    S x[kInputs * 2], y[kOutputs * 2];
    mirrored(features, s, x);
    typename Net::template Tape<2, S> tape;
    net_.template forward<2>(theta + kCommon, x, y, tape);

    // backbone
    const S t = tanh(in.v / theta[kV0]);
    const S v_per_v0 = in.v / theta[kV0];
    const S t_bar = tau_bar * theta[kF0] * (S(1) - t * t) / theta[kV0];
    const S factor = S(1) + (y[2] + y[3]);
    theta_bar[kF0] += tau_bar * t;
    theta_bar[kV0] -= t_bar * v_per_v0;
    theta_bar[kFv] += tau_bar * in.v;
    theta_bar[kFc] += tau_bar * (y[0] - y[1]);
    in_bar.v += t_bar + tau_bar * theta[kFv];
    for (int i = 0; i < kLatents; ++i) {
      theta_bar[K(i)] += tau_bar * factor * s[i];
      s_bar[i] += tau_bar * factor * theta[K(i)];
    }

    // network
    const S n0_bar = tau_bar * theta[kFc], n1_bar = tau_bar * bristles(theta, s);
    const S y_bar[kOutputs * 2] = {n0_bar, -n0_bar, n1_bar, n1_bar};
    S x_bar[kInputs * 2];
    for (S& bar : x_bar) bar = S(0);
    net_.template pullback<2>(theta + kCommon, x, tape, y_bar, theta_bar + kCommon, x_bar);
    const auto odd = [&](int i) { return x_bar[2 * i] - x_bar[2 * i + 1]; };
    for (int i = 0; i < kLatents; ++i) s_bar[i] += odd(3 + i);
    const S load_bar = x_bar[2 * (kInputs - 1)] + x_bar[2 * (kInputs - 1) + 1];
    features.pull_back(theta + kScales, in.v, in.load, {odd(0), odd(1), odd(2), load_bar},
                       theta_bar + kScales, in_bar.v, in_bar.load);
  }

  template <class S>
  void step_pullback(const S* theta, const Input<S>& in, double dt, const S* s, const S* s_next_bar,
                     S* theta_bar, Input<S>& in_bar, S* s_bar) const {
    const S speed = abs(in.v);
    const NetInputs<S> features = NetInputs<S>::of(theta + kScales, speed, in.load);
    const S direction = select(in.v < S(0), S(-1), S(1));
    NetInputs<S> features_bar{S(0), S(0), S(0), S(0)};
    S speed_bar = S(0);
    for (int i = 0; i < kLatents; ++i) {
      S x[kRateInputs], r;
      rate_inputs(features, direction * s[i], x);
      RateNet::template Tape<1, S> tape;
      kRateNet.forward<1>(theta + rate_begin(i), x, &r, tape);
      const S rho = rate(r);
      const S per_length = S(1) / theta[delta(i)];
      const BristleBar<S> bar = bristle_step_pullback(in.v * per_length, rho * speed * per_length,
                                                      dt, s[i], s_next_bar[i]);

      const S decay_bar = bar.r * per_length;  // of rho |v|
      theta_bar[delta(i)] -= (bar.v * in.v + bar.r * rho * speed) * per_length * per_length;
      in_bar.v += bar.v * per_length;
      speed_bar += decay_bar * rho;
      const S share = tanh(r / S(kLogRateLimit));
      const S r_bar = decay_bar * speed * rho * (S(1) - share * share);
      S x_bar[kRateInputs];
      for (S& b : x_bar) b = S(0);
      kRateNet.pullback<1>(theta + rate_begin(i), x, tape, &r_bar, theta_bar + rate_begin(i),
                           x_bar);
      features_bar.v += x_bar[0];
      features_bar.v1 += x_bar[1];
      features_bar.v2 += x_bar[2];
      s_bar[i] += bar.z + direction * x_bar[3];
      features_bar.load += x_bar[4];
    }
    features.pull_back(theta + kScales, speed, in.load, features_bar, theta_bar + kScales,
                       speed_bar, in_bar.load);
    in_bar.v += speed_bar * sign(in.v);
  }

  /// Torque at an equilibrium of all latents, rho_i sgn(v) s_i = 1, found by bisection of
  /// e^-3 .. e^3. There is at least one; with several, the state decides which one sliding
  /// reaches. v = 0 returns 0.
  template <class S>
  S steady_torque(const S* theta, const Input<S>& in) const {
    constexpr int kHalvings = 60;
    const NetInputs<S> features = NetInputs<S>::of(theta + kScales, abs(in.v), in.load);
    S s[kLatents];
    for (int i = 0; i < kLatents; ++i) {
      S low = exp(S(-kLogRateLimit)), high = exp(S(kLogRateLimit));
      for (int k = 0; k < kHalvings; ++k) {
        const S middle = S(0.5) * (low + high);
        S x[kRateInputs], r;
        rate_inputs(features, middle, x);
        kRateNet.forward<1>(theta + rate_begin(i), x, &r);
        const auto rises = rate(r) * middle < S(1);
        low = select(rises, middle, low);
        high = select(rises, high, middle);
      }
      s[i] = sign(in.v) * low;
    }
    return torque(theta, in, static_cast<const S*>(s));
  }

  void state_bound(const double*, double, double* bound) const {
    for (int i = 0; i < kLatents; ++i) bound[i] = std::exp(kLogRateLimit);
  }

 private:
  static constexpr int kInputs = 4 + kLatents, kOutputs = 2, kRateInputs = 5;
  using Net = Mlp<Activation::kMish, kInputs, 2, kOutputs, kMostElements>;
  using RateNet = Mlp<Activation::kMish, kRateInputs, 1, 1, kRateWidth>;
  static constexpr RateNet kRateNet{kRateWidth};

  template <class S>
  [[gnu::noinline, gnu::flatten]] S torque_of(const S* theta, const Input<S>& in,
                                              const NetInputs<S>& features, const S* s) const {
    S x[kInputs * 2], y[kOutputs * 2];
    mirrored(features, s, x);
    net_.template forward<2>(theta + kCommon, x, y);
    return theta[kF0] * tanh(in.v / theta[kV0]) + theta[kFv] * in.v +
           bristles(theta, s) * (S(1) + (y[2] + y[3])) + theta[kFc] * (y[0] - y[1]);
  }

  // Stage by stage: the latents share the processor. Features of |v|.
  template <class S>
  [[gnu::noinline, gnu::flatten]] void step_by(const S* theta, const Input<S>& in,
                                               const NetInputs<S>& features, double dt,
                                               S* s) const {
    const S direction = select(in.v < S(0), S(-1), S(1));
    S x[kLatents * kRateInputs], r[kLatents];
    for (int i = 0; i < kLatents; ++i) rate_inputs(features, direction * s[i], x + i * kRateInputs);
    kRateNet.forward_each<kLatents>(theta + rate_begin(0), x, r);
    for (S& each : r) each = log_rate(each);
    for (S& each : r) each = exp(each);
    for (int i = 0; i < kLatents; ++i) {
      const S per_length = S(1) / theta[delta(i)];
      s[i] = bristle_step(in.v * per_length, r[i] * abs(in.v) * per_length, dt, s[i]);
    }
  }

  // where the weights of r_i begin, after those of the torque
  constexpr int rate_begin(int i) const {
    return kCommon + net_.weight_count() + i * kRateNet.weight_count();
  }

  template <class S>  // x and its mirror image, side by side
  static void mirrored(const NetInputs<S>& features, const S* s, S* x) {
    const auto odd = [x](int i, const S& value) {
      x[2 * i] = value;
      x[2 * i + 1] = -value;
    };
    odd(0, features.v);
    odd(1, features.v1);
    odd(2, features.v2);
    for (int i = 0; i < kLatents; ++i) odd(3 + i, s[i]);
    x[2 * (kInputs - 1)] = x[2 * (kInputs - 1) + 1] = features.load;
  }

  template <class S>
  static void rate_inputs(const NetInputs<S>& features, const S& s_ahead, S* x) {
    x[0] = features.v;
    x[1] = features.v1;
    x[2] = features.v2;
    x[3] = s_ahead;
    x[4] = features.load;
  }

  template <class S>  // rho from the network's output
  static S rate(const S& r) {
    return exp(log_rate(r));
  }
  template <class S>
  static S log_rate(const S& r) {
    return S(kLogRateLimit) * tanh(r / S(kLogRateLimit));
  }

  template <class S>  // torque of the bristles alone [N m]
  static S bristles(const S* theta, const S* s) {
    S sum = theta[K(0)] * s[0];
    for (int i = 1; i < kLatents; ++i) sum += theta[K(i)] * s[i];
    return sum;
  }

  // typical: 5 N m, nine tenths of it from bristles of growing length
  static constexpr double kBristleTorque = 4.5;
  static constexpr auto kTable = [] {
    constexpr double kLengths[3][4] = {{2.5e-3}, {1e-3, 5e-3}, {8e-4, 2e-3, 5e-3, 1.2e-2}};
    std::array<ParameterInfo, kCommon> common{{
        {"F0", "N m", Role::kMemoryless, 0, 1e6, 0.5, Scale::kLinear,
         "Coulomb friction without memory"},
        {"v0", "rad/s", Role::kSmoothingSpeed, 1e-5, 1, 0.05, Scale::kLog, "smoothing speed of F0"},
        {"Fv", "N m s/rad", Role::kViscous, 0, 1e6, 2.5, Scale::kLinear, "viscous coefficient"},
        {"Fc", "N m", Role::kNetworkTorque, 1e-6, 1e6, 5, Scale::kLog,
         "size of the network's torque"},
    }};
    for (std::size_t i = 0; i < kNetInputScales.size(); ++i)
      common[kScales + i] = kNetInputScales[i];
    for (int i = 0; i < kLatents; ++i) {
      common[static_cast<std::size_t>(K(i))] = {
          numbered<"K">(i),          "N m",       Role::kLevel,           1e-8, 1e6,
          kBristleTorque / kLatents, Scale::kLog, "level of the bristle", i + 1};
      common[static_cast<std::size_t>(delta(i))] = {
          numbered<"Delta">(i),      "rad",       Role::kLength,           1e-6, 1,
          kLengths[kLatents / 2][i], Scale::kLog, "length of the bristle", i + 1};
    }
    return weight_table<Net(kMostElements).weight_count() + kLatents * kRateNet.weight_count()>(
        common);
  }();

  Net net_;
};

using Lvm1 = BasicLvm<1>;
using Lvm = BasicLvm<2>;
using Lvm4 = BasicLvm<4>;

}  // namespace fricid::friction
