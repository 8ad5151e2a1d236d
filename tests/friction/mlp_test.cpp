// Dense networks: forward against plain loops, backward against dual numbers, starting weights.
#include "fricid/friction/mlp.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "dual.hpp"
#include "fricid/base/rng.hpp"

namespace fricid::friction::test {
namespace {

using fricid::test::Dual;

constexpr int kInputs = 3, kOutputs = 2, kMostWidth = 9;
template <Activation activation, int kHidden>
using Net = Mlp<activation, kInputs, kHidden, kOutputs, kMostWidth>;

std::vector<double> draw(std::size_t n, std::uint64_t stream) {
  Rng rng(7, stream);
  std::vector<double> x(n);
  for (double& value : x) value = rng.normal();
  return x;
}

double reference(Activation activation, double x) {
  if (activation == Activation::kMish) return x * std::tanh(std::log1p(std::exp(x)));
  return activation == Activation::kTanh ? std::tanh(x) : std::max(x, 0.0);
}

// y = W h + b, one number at a time; moves `weights` on to the next layer.
std::vector<double> layer(const double*& weights, std::size_t outputs,
                          const std::vector<double>& h) {
  std::vector<double> y(weights + outputs * h.size(), weights + outputs * (h.size() + 1));
  for (std::size_t r = 0; r < outputs; ++r)
    for (std::size_t c = 0; c < h.size(); ++c) y[r] += weights[r * h.size() + c] * h[c];
  weights += outputs * (h.size() + 1);
  return y;
}

/// Calls f(net, activation, hidden layers) for all kinds of networks: blocks of rows, remainders,
/// both at once.
template <class F>
void for_each_net(F&& f) {
  for (const int width : {1, 3, 4, kMostWidth}) {
    SCOPED_TRACE(width);
    f(Net<Activation::kMish, 1>(width), Activation::kMish, 1);
    f(Net<Activation::kMish, 2>(width), Activation::kMish, 2);
    f(Net<Activation::kRelu, 2>(width), Activation::kRelu, 2);
    f(Net<Activation::kTanh, 3>(width), Activation::kTanh, 3);
  }
}

TEST(Mlp, EqualsPlainLoops) {
  for_each_net([](const auto& net, Activation activation, int hidden) {
    const auto weights = draw(static_cast<std::size_t>(net.weight_count()), 1);
    const auto x = draw(2 * kInputs, 2);
    double y[2 * kOutputs];
    net.template forward<2>(weights.data(), x.data(), y);
    for (std::size_t column = 0; column < 2; ++column) {
      const double* at = weights.data();
      std::vector<double> h;
      for (std::size_t i = 0; i < kInputs; ++i) h.push_back(x[2 * i + column]);
      for (int l = 0; l < hidden; ++l) {
        h = layer(at, static_cast<std::size_t>(net.width()), h);
        for (double& unit : h) unit = reference(activation, unit);
      }
      h = layer(at, kOutputs, h);
      EXPECT_EQ(at, weights.data() + weights.size());
      for (std::size_t i = 0; i < kOutputs; ++i) EXPECT_NEAR(y[2 * i + column], h[i], 1e-12);
    }
  });
}

template <class S>
void expect_lanes_are_scalars(const std::vector<double>& x) {
  using Scalar = decltype(lane(S(), 0));
  constexpr int kLanes = kLaneCount<S>;
  const int n = static_cast<int>(x.size());
  std::vector<S> packs;
  for (int i = 0; i < n; ++i) {
    S& pack = packs.emplace_back();
    for (int k = 0; k < kLanes; ++k)
      set_lane(pack, k, static_cast<Scalar>(x[static_cast<std::size_t>((i + 3 * k) % n)]));
  }
  const std::vector<S> before = packs;
  activate_all<Activation::kMish>(packs.data(), n);
  for (std::size_t i = 0; i < packs.size(); ++i)
    for (int k = 0; k < kLanes; ++k)
      EXPECT_EQ(to_bits(lane(packs[i], k)),
                to_bits(activate<Activation::kMish>(lane(before[i], k))))
          << lane(before[i], k);
}

TEST(Mlp, UnitsSideBySideAreUnitsAlone) {
  // blocks of units and a remainder
  const std::vector<double> x{-1e300, -745.2, -700, -88, -1,  -1e-9,   -0.0,
                              0,      1e-300, 0.3,  24,  1e9, HUGE_VAL};
  expect_lanes_are_scalars<PackD>(x);
  expect_lanes_are_scalars<PackF>(x);
  expect_lanes_are_scalars<double>(x);
}

TEST(Mlp, NetworksSideBySideAreNetworksAlone) {
  for_each_net([](const auto& net, Activation, int) {
    constexpr int kNets = 3;
    const auto n = static_cast<std::size_t>(net.weight_count());
    const auto weights = draw(kNets * n, 1), x = draw(kNets * kInputs, 2);
    double y[kNets * kOutputs], alone[kOutputs];
    net.template forward_each<kNets>(weights.data(), x.data(), y);
    for (std::size_t k = 0; k < kNets; ++k) {
      net.template forward<1>(weights.data() + k * n, x.data() + k * kInputs, alone);
      for (std::size_t i = 0; i < kOutputs; ++i) EXPECT_EQ(y[k * kOutputs + i], alone[i]);
    }
  });
}

// Checks against dual numbers; the bars start at one, since the pullback adds to them.
template <int kColumns, class Network>
void expect_pullback_is_exact(const Network& net) {
  constexpr std::size_t kX = kInputs * kColumns, kY = kOutputs * kColumns;
  const auto n = static_cast<std::size_t>(net.weight_count());
  const auto weights = draw(n, 3), x = draw(kX, 4), y_bar = draw(kY, 5);
  std::vector<double> weights_bar(n, 1.0), x_bar(kX, 1.0), y(kY), y_plain(kY);
  typename Network::template Tape<kColumns, double> tape;
  net.template forward<kColumns>(weights.data(), x.data(), y.data(), tape);
  net.template pullback<kColumns>(weights.data(), x.data(), tape, y_bar.data(), weights_bar.data(),
                                  x_bar.data());
  net.template forward<kColumns>(weights.data(), x.data(), y_plain.data());
  for (std::size_t i = 0; i < kY; ++i) EXPECT_NEAR(y[i], y_plain[i], 1e-13);

  std::vector<Dual> w(weights.begin(), weights.end()), in(x.begin(), x.end()), out(kY);
  const auto slope = [&](Dual& along) {
    along.d = 1;
    net.template forward<kColumns>(w.data(), in.data(), out.data());
    along.d = 0;
    double sum = 0;
    for (std::size_t i = 0; i < kY; ++i) sum += y_bar[i] * out[i].d;
    return sum;
  };
  for (std::size_t i = 0; i < n; ++i) EXPECT_NEAR(weights_bar[i] - 1, slope(w[i]), 1e-12) << i;
  for (std::size_t i = 0; i < kX; ++i) EXPECT_NEAR(x_bar[i] - 1, slope(in[i]), 1e-12) << i;
}

TEST(Mlp, PullbackEqualsDualNumbers) {
  for_each_net([](const auto& net, Activation, int) {
    expect_pullback_is_exact<1>(net);
    expect_pullback_is_exact<2>(net);
  });
}

TEST(Mlp, SlopesHoldFarOut) {
  for (const double x : {-1e3, -40.0, -1.2, 0.0, 5.0, 23.0, 25.0, 1e3}) {
    const auto mish_at = activate_with_slope<Activation::kMish>(x);
    const Dual expected = x > 30 ? Dual(x, 1) : mish(Dual(x, 1));
    EXPECT_NEAR(mish_at.value, expected.x, 1e-13 * (1 + std::abs(x))) << x;
    EXPECT_NEAR(mish_at.slope, expected.d, 1e-13) << x;
    const auto single = activate_with_slope<Activation::kMish>(static_cast<float>(x));
    EXPECT_NEAR(single.slope, expected.d, 1e-5) << x;
  }
}

TEST(Mlp, StartsWithUnitGainAndASmallOutput) {
  constexpr int kWidth = 32;
  const Mlp<Activation::kMish, 50, 2, 1, kWidth> net(kWidth);
  std::vector<double> weights(static_cast<std::size_t>(net.weight_count()), 99.0);
  Rng rng(3, 1);
  net.initialise(weights.data(), rng, 0.01);

  const auto mean_square = [&](int begin, int size) {
    double sum = 0;
    for (int i = begin; i < begin + size; ++i)
      sum += weights[static_cast<std::size_t>(i)] * weights[static_cast<std::size_t>(i)] / size;
    return sum;
  };
  const int second = 51 * kWidth, output = second + 33 * kWidth;
  EXPECT_NEAR(mean_square(0, 50 * kWidth) * 50, 1, 0.15);
  EXPECT_NEAR(mean_square(second, kWidth * kWidth) * kWidth, 1, 0.15);
  EXPECT_NEAR(mean_square(output, kWidth) * kWidth / 1e-4, 1, 0.6);
  EXPECT_EQ(mean_square(50 * kWidth, kWidth), 0);
  EXPECT_EQ(mean_square(second + kWidth * kWidth, kWidth), 0);
  EXPECT_EQ(weights.back(), 0);
}

}  // namespace
}  // namespace fricid::friction::test
