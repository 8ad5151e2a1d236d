#include "fricid/signals/overview.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>

#include "fricid/base/rng.hpp"

namespace fricid::signals {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

/// q = amplitude sin(2 pi t) over 10 s at 250 Hz, torque 3 N m in alternating directions.
Dataset sine(double amplitude, double noise) {
  constexpr int kRows = 2500;
  Dataset log;
  log.joint_names = {"a"};
  log.rate_hz = 250;
  log.t = Eigen::VectorXd::LinSpaced(kRows, 0, (kRows - 1) / log.rate_hz);
  log.q.resize(kRows, 1);
  log.tau.resize(kRows, 1);
  Rng rng(3, 1);
  for (Eigen::Index k = 0; k < kRows; ++k) {
    log.q(k, 0) = amplitude * std::sin(2 * std::numbers::pi * log.t[k]) + noise * rng.normal();
    log.tau(k, 0) = k % 2 == 0 ? 3 : -3;
  }
  return log;
}

TEST(Overview, OfASineIsItsOwn) {
  const JointOverview found = overview(sine(0.5, 1e-5), 0);
  EXPECT_NEAR(found.low, -0.5, 1e-3);
  EXPECT_NEAR(found.high, 0.5, 1e-3);
  EXPECT_NEAR(found.fastest, std::numbers::pi, 0.02);
  EXPECT_EQ(found.reversals, 20);
  EXPECT_DOUBLE_EQ(found.torque_rms, 3);
  EXPECT_EQ(found.torque_peak, 3);
  EXPECT_EQ(found.missing, 0);
}

TEST(Overview, MissingSamplesAreCountedAndLeftOut) {
  Dataset log = sine(0.5, 1e-5);
  log.q(10, 0) = log.tau(10, 0) = log.tau(11, 0) = kNan;
  const JointOverview found = overview(log, 0);
  EXPECT_EQ(found.missing, 2);
  EXPECT_DOUBLE_EQ(found.torque_rms, 3);
  EXPECT_EQ(found.reversals, 20);
  log.tau.setConstant(kNan);
  EXPECT_TRUE(std::isnan(overview(log, 0).torque_rms));
}

// White noise of known size on a motion a thousand times as large.
TEST(Overview, NoiseIsToldFromMotion) {
  for (const double noise : {1e-5, 1e-4})
    EXPECT_NEAR(noise_of_differences(sine(0.1, noise).q.col(0)) / noise, 1, 0.1);
  EXPECT_TRUE(std::isnan(noise_of_differences(Eigen::VectorXd::Zero(4))));
}

TEST(Overview, NoiseIsNoReversal) { EXPECT_EQ(overview(sine(0, 1e-4), 0).reversals, 0); }

TEST(Overview, SlopeOfALineIsTheSameEverywhere) {
  const Eigen::VectorXd t = Eigen::VectorXd::LinSpaced(5, 1, 3);
  EXPECT_TRUE(slope(4 * t, t).isApproxToConstant(4, 1e-14));
}

}  // namespace
}  // namespace fricid::signals
