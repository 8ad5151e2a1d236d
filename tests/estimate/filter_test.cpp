#include "fricid/estimate/filter.hpp"

#include <cmath>
#include <limits>
#include <numbers>

#include <gmock/gmock.h>

#include "fricid/base/error.hpp"
#include "fricid/base/pack.hpp"
#include "fricid/base/rng.hpp"
#include "fricid/estimate/recording.hpp"

namespace fricid::estimate {
namespace {

constexpr double kRate = 250, kCutoff = 10;
constexpr double kTau = 2 * std::numbers::pi;

std::vector<double> filtered(std::vector<double> x, double cutoff = kCutoff) {
  std::vector<double> work;
  ZeroPhaseButterworth(cutoff, kRate).apply(std::span<double>(x), work);
  return x;
}

// A one-joint log of T samples from functions of time.
template <class Position, class Torque>
data::Dataset make_log(int T, Position position, Torque torque) {
  data::Dataset log;
  log.name = "log";
  log.joint_names = {"joint"};
  log.rate_hz = kRate;
  log.t = Eigen::VectorXd::LinSpaced(T, 0, (T - 1) / kRate);
  log.q.resize(T, 1);
  log.tau.resize(T, 1);
  for (int k = 0; k < T; ++k) {
    log.q(k, 0) = position(log.t[k]);
    log.tau(k, 0) = torque(log.t[k]);
  }
  return log;
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

// Reference: central differences of the filtered sine, exact in the middle of the log.
TEST(FilterDataset, DifferentiatesTheFilteredPosition) {
  const double f = 1.5, w = kTau * f, dt = 1 / kRate;
  const auto log = make_log(
      2500, [&](double t) { return std::sin(w * t); }, [](double) { return 0.0; });
  const Filtered out = filter_dataset(log, kCutoff);
  const double gain = ZeroPhaseButterworth(kCutoff, kRate).gain(f);
  for (int k = 1000; k < 1500; ++k) {
    const double t = log.t[k];
    ASSERT_NEAR(out.v(k, 0), gain * std::cos(w * t) * std::sin(w * dt) / dt, 1e-9);
    ASSERT_NEAR(out.a(k, 0), gain * std::sin(w * t) * 2 * (std::cos(w * dt) - 1) / (dt * dt), 1e-7);
  }
}

// Reference: a unit mass under held torque. q at the samples is exact, so the second difference of
// q must equal the torque in force around each sample: a log shifted by one sample fails here.
TEST(FilterDataset, AlignsHeldTorqueWithTheAccelerationOfAUnitMass) {
  const int T = 3000;
  const double dt = 1 / kRate;
  auto log = make_log(
      T, [](double) { return 0.0; },
      [](double t) { return std::sin(kTau * 3 * t) + 0.5 * std::cos(kTau * t); });
  double q = 0, v = 0.1;
  for (int k = 0; k < T; ++k) {
    log.q(k, 0) = q;
    const double a = log.tau(k, 0);
    q += dt * v + 0.5 * dt * dt * a;
    v += dt * a;
  }
  const Filtered out = filter_dataset(log, kCutoff);
  for (int k = 1000; k < 2000; ++k) ASSERT_NEAR(out.a(k, 0), out.tau(k, 0), 1e-8);
}

TEST(FilterDataset, BridgesMissingSamplesAndLeavesThemOut) {
  auto log = make_log(
      2000, [](double t) { return t; }, [](double t) { return 2 * t; });
  for (int k = 900; k < 905; ++k) log.q(k, 0) = log.tau(k, 0) = std::nan("");
  const Filtered out = filter_dataset(log, kCutoff);
  EXPECT_NEAR(out.q(902, 0), log.t[902], 1e-10);
  EXPECT_NEAR(out.tau(902, 0), 2 * (log.t[902] - 0.5 / kRate), 1e-9);
  EXPECT_FALSE(out.use(902, 0));
  EXPECT_FALSE(out.use(880, 0));
  EXPECT_TRUE(out.use(870, 0));
  EXPECT_FALSE(out.use(0, 0));
  EXPECT_FALSE(out.use(1999, 0));
}

// A joint that has not yet moved keeps a friction state that the log cannot know.
TEST(FilterDataset, LeavesOutAJointUntilItHasMoved) {
  const auto log = make_log(
      2000, [](double t) { return t < 4 ? 1.0 : 1.0 + 0.1 * (t - 4); }, [](double) { return 0.0; });
  const Filtered out = filter_dataset(log, kCutoff);
  const int moved = static_cast<int>((4 + kWashout / 0.1) * kRate);
  EXPECT_FALSE(out.use(moved - 2, 0));
  EXPECT_TRUE(out.use(moved + 2, 0));
}

// Five times this cut-off lies beyond the Nyquist frequency: the wide band ends at 0.4 of the rate.
TEST(MakeRecording, FindsTheEncoderNoiseAtAHighCutoff) {
  constexpr double kNoise = 1e-5, kHighCutoff = 30;
  Rng rng(1, 0);
  const data::Dataset log = make_log(
      5000, [&](double t) { return 0.5 * std::sin(t) + kNoise * rng.normal(); },
      [](double) { return 0.0; });
  const Recording recording = make_recording(log, filter_dataset(log, kHighCutoff), kHighCutoff);
  EXPECT_NEAR(recording.noise_sd[0], kNoise, 0.1 * kNoise);
}

TEST(FilterDataset, RefusesWhatItCannotFilter) {
  const auto zero = [](double) { return 0.0; };
  EXPECT_THROW(filter_dataset(make_log(100, zero, zero), kCutoff), UserError);
  auto empty = make_log(1000, zero, zero);
  empty.tau.setConstant(std::nan(""));
  EXPECT_THROW(filter_dataset(empty, kCutoff), UserError);
}

TEST(Decimation, KeepsTwoSamplesPerPeriodOfTheCutoff) {
  EXPECT_EQ(decimation(0.004, 10), 12);
  EXPECT_EQ(decimation(0.004, 100), 1);
  EXPECT_EQ(decimation(0.004, 200), 1);
}

}  // namespace
}  // namespace fricid::estimate
