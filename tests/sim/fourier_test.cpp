#include "fricid/sim/fourier.hpp"

#include <gtest/gtest.h>

#include <numbers>

#include "fricid/base/rng.hpp"

namespace fricid::sim::test {
namespace {

Fourier random_series(int n, int harmonics, double w) {
  Rng rng(3, 0);
  Fourier series{w, Eigen::VectorXd(n), Eigen::MatrixXd(n, harmonics),
                 Eigen::MatrixXd(n, harmonics)};
  for (double& x : series.q0) x = rng.normal();
  for (double& x : series.a.reshaped()) x = rng.normal();
  for (double& x : series.b.reshaped()) x = rng.normal();
  return series;
}

// Closed form of one harmonic: a = 0, b = A k w gives q = q0 - A cos(k w t).
TEST(Fourier, OneHarmonicIsACosine) {
  Fourier series{0.5, Eigen::VectorXd::Constant(1, 0.7), Eigen::MatrixXd::Zero(1, 3),
                 Eigen::MatrixXd::Zero(1, 3)};
  constexpr double kAmplitude = 0.4, kRate = 1.5;
  series.b(0, 2) = kAmplitude * kRate;
  const Eigen::VectorXd t = Eigen::VectorXd::LinSpaced(50, -1, 9);
  const Motion motion = TimeGrid(series.w, 3, t).sample(series);
  for (int k = 0; k < 50; ++k) {
    const double c = kAmplitude * std::cos(kRate * t[k]), s = kAmplitude * std::sin(kRate * t[k]);
    EXPECT_NEAR(motion.q(0, k), 0.7 - c, 1e-14);
    EXPECT_NEAR(motion.v(0, k), kRate * s, 1e-14);
    EXPECT_NEAR(motion.a(0, k), kRate * kRate * c, 1e-14);
    EXPECT_NEAR(motion.jerk(0, k), -kRate * kRate * kRate * s, 1e-14);
  }
}

TEST(Fourier, DerivativesMatchFiniteDifferences) {
  const Fourier series = random_series(4, 20, 0.2);
  constexpr double kStep = 1e-4;
  for (const double t : {0.0, 3.3, 17.0}) {
    const Motion m =
        TimeGrid(series.w, 20, Eigen::Vector3d(t - kStep, t, t + kStep)).sample(series);
    const auto slope = [](const Eigen::MatrixXd& x) { return (x.col(2) - x.col(0)) / (2 * kStep); };
    // truncation (k w)^3 step^2 / 6 of the fastest harmonic, times the amplitudes
    EXPECT_LT((slope(m.q) - m.v.col(1)).cwiseAbs().maxCoeff(), 1e-6);
    EXPECT_LT((slope(m.v) - m.a.col(1)).cwiseAbs().maxCoeff(), 1e-6);
    EXPECT_LT((slope(m.a) - m.jerk.col(1)).cwiseAbs().maxCoeff(), 1e-5);
  }
}

TEST(Fourier, StartsAndEndsAtRestWithTheLeastChange) {
  const Fourier before = random_series(6, 20, 0.2);
  Fourier series = before;
  start_at_rest(series);
  const Motion ends = TimeGrid(series.w, 20, Eigen::Vector2d(0, series.period())).sample(series);
  EXPECT_LT(ends.v.cwiseAbs().maxCoeff(), 1e-12);
  EXPECT_LT(ends.a.cwiseAbs().maxCoeff(), 1e-11);
  EXPECT_LT((ends.q.col(0) - ends.q.col(1)).cwiseAbs().maxCoeff(), 1e-12);
  // the change is normal to the set of series at rest, so no smaller one does
  EXPECT_LT((series.a - before.a).cwiseProduct(series.a).sum(), 1e-12);
  EXPECT_LT((series.b - before.b).cwiseProduct(series.b).sum(), 1e-12);
}

}  // namespace
}  // namespace fricid::sim::test
