#include "fricid/signals/filter.hpp"

#include <cmath>
#include <numbers>

#include <gmock/gmock.h>

#include "fricid/base/error.hpp"
#include "fricid/base/pack.hpp"
#include "fricid/base/rng.hpp"

namespace fricid::signals {
namespace {

constexpr double kRate = 250, kCutoff = 10;
constexpr double kTau = 2 * std::numbers::pi;

std::vector<double> filtered(std::vector<double> x, double cutoff = kCutoff) {
  std::vector<double> work;
  ZeroPhaseButterworth(cutoff, kRate).apply(std::span<double>(x), work);
  return x;
}

// Reference: closed form. |H|^2 of the continuous Butterworth prototype under the bilinear map.
TEST(ZeroPhaseButterworth, MultipliesASineByItsGainWithoutShift) {
  const ZeroPhaseButterworth low_pass(kCutoff, kRate);
  for (const double f : {0.5, 2.0, 5.0, 10.0, 20.0}) {
    SCOPED_TRACE(f);
    const double ratio =
        std::tan(std::numbers::pi * f / kRate) / std::tan(std::numbers::pi * kCutoff / kRate);
    const double gain = 1 / (1 + std::pow(ratio, 8));
    EXPECT_NEAR(low_pass.gain(f), gain, 1e-14);

    std::vector<double> x(3000);
    for (std::size_t k = 0; k < x.size(); ++k)
      x[k] = std::sin(kTau * f * static_cast<double>(k) / kRate + 0.7);
    const std::vector<double> y = filtered(x);
    // Away from the ends the edge continuation has died out.
    for (std::size_t k = 1000; k < 2000; ++k) ASSERT_NEAR(y[k], gain * x[k], 1e-12);
  }
}

TEST(ZeroPhaseButterworth, HalvesPowerTwiceAtTheCutoff) {
  EXPECT_DOUBLE_EQ(ZeroPhaseButterworth(kCutoff, kRate).gain(kCutoff), 0.5);
}

TEST(ZeroPhaseButterworth, PassesConstantsAndStraightLinesToTheEnds) {
  std::vector<double> constant(1000, 3.25), line(1000);
  for (std::size_t k = 0; k < line.size(); ++k) line[k] = 2 - 0.01 * static_cast<double>(k);
  const std::vector<double> c = filtered(constant), l = filtered(line);
  for (std::size_t k = 0; k < line.size(); ++k) {
    ASSERT_NEAR(c[k], constant[k], 1e-13);
    ASSERT_NEAR(l[k], line[k], 1e-12);
  }
}

TEST(ZeroPhaseButterworth, IsTheSameRunForwardsAndBackwards) {
  std::vector<double> x(700);
  for (std::size_t k = 0; k < x.size(); ++k) x[k] = std::sin(0.001 * static_cast<double>(k * k));
  std::vector<double> reversed(x.rbegin(), x.rend());
  const std::vector<double> y = filtered(x), z = filtered(reversed);
  for (std::size_t k = 0; k < x.size(); ++k) ASSERT_NEAR(y[k], z[x.size() - 1 - k], 1e-12);
}

TEST(ZeroPhaseButterworth, LaneOfAPackEqualsTheScalarFilter) {
  std::vector<PackD> x(500, PackD(0));
  std::vector<std::vector<double>> lanes(kLaneCount<PackD>, std::vector<double>(x.size()));
  for (int lane = 0; lane < kLaneCount<PackD>; ++lane)
    for (std::size_t k = 0; k < x.size(); ++k) {
      const double value = std::cos(0.01 * static_cast<double>(k) * (lane + 1)) + lane;
      lanes[static_cast<std::size_t>(lane)][k] = value;
      x[k].set(lane, value);
    }
  std::vector<PackD> work;
  ZeroPhaseButterworth(kCutoff, kRate).apply(std::span<PackD>(x), work);
  for (int lane = 0; lane < kLaneCount<PackD>; ++lane) {
    const std::vector<double> y = filtered(lanes[static_cast<std::size_t>(lane)]);
    for (std::size_t k = 0; k < x.size(); ++k) ASSERT_EQ(x[k][lane], y[k]);
  }
}

TEST(ZeroPhaseButterworth, RefusesACutoffAboveNyquist) {
  EXPECT_THROW(ZeroPhaseButterworth(125, 250), UserError);
  EXPECT_THROW(ZeroPhaseButterworth(0, 250), UserError);
}

TEST(Decimation, KeepsTwoSamplesPerPeriodOfTheCutoff) {
  EXPECT_EQ(decimation(0.004, 10), 12);
  EXPECT_EQ(decimation(0.004, 100), 1);
  EXPECT_EQ(decimation(0.004, 200), 1);
}

TEST(ImpulseResponse, IsTheZeroPhaseFilterToOnePercent) {
  const ZeroPhaseButterworth filter(kCutoff, kRate);
  const std::vector<double> g = impulse_response(filter);
  EXPECT_LT(g.size(), 80u);
  Rng rng(1, 0);
  std::vector<double> x(600), work;
  for (double& value : x) value = rng.uniform() < 0.5 ? -1 : 1;
  std::vector<double> y = x;
  filter.apply(std::span<double>(y), work);
  const auto K = g.size() - 1;
  for (std::size_t k = 200; k < 400; ++k) {
    double sum = g[0] * x[k];
    for (std::size_t m = 1; m <= K; ++m) sum += g[m] * (x[k - m] + x[k + m]);
    EXPECT_NEAR(sum, y[k], 0.015) << "of 1";
  }
}

}  // namespace
}  // namespace fricid::signals
