#include "fricid/evaluate/repeats.hpp"

#include <gtest/gtest.h>

#include <numbers>

#include "contest.hpp"

namespace fricid::test {
namespace {

using evaluate::find_repeats;
using evaluate::Repeats;

constexpr double kQNoise = 2e-5, kTauNoise = 0.3;

/// Two joints on a Fourier motion of period `period_s`, with white noise.
data::Dataset periodic(double period_s, double length_s, double rate_hz = 250) {
  data::Dataset d;
  const auto T = static_cast<Eigen::Index>(std::lround(length_s * rate_hz)) + 1;
  d.name = "log";
  d.joint_names = {"a", "b"};
  d.rate_hz = rate_hz;
  d.t = Eigen::VectorXd::LinSpaced(T, 0, static_cast<double>(T - 1) / rate_hz);
  d.q.resize(T, 2);
  d.tau.resize(T, 2);
  Rng rng(3, 1);
  for (Eigen::Index k = 0; k < T; ++k) {
    const double w = 2 * std::numbers::pi * d.t[k] / period_s;
    d.q(k, 0) = 0.4 * std::sin(w) + 0.3 * std::cos(3 * w) + kQNoise * rng.normal();
    d.q(k, 1) = 0.2 * std::sin(2 * w) + 0.5 * std::cos(5 * w) + kQNoise * rng.normal();
    for (int j = 0; j < 2; ++j)
      d.tau(k, j) = 10 * std::sin(w) + 3 * d.q(k, j) + kTauNoise * rng.normal();
  }
  return d;
}

TEST(Repeats, FindThePeriodAndTheNoise) {
  for (const double period : {3.0, 7.864, 12.4}) {
    const Repeats repeats = find_repeats(periodic(period, 25));
    EXPECT_NEAR(repeats.period_s, period, 0.0041) << period;
    for (std::size_t j = 0; j < 2; ++j) {
      EXPECT_NEAR(repeats.tau_sd[j], kTauNoise, 0.02 * kTauNoise);
      // half a sample of the period's remainder moves q, the torque hardly
      EXPECT_LT(repeats.q_sd[j], 5e-3);
    }
  }
  EXPECT_NEAR(find_repeats(periodic(7.864, 25)).q_sd[0], kQNoise, 0.05 * kQNoise);
}

TEST(Repeats, OneAndAHalfPeriodsAreNone) {
  EXPECT_EQ(find_repeats(periodic(10, 15)).period_s, 0);
  EXPECT_TRUE(find_repeats(periodic(10, 15)).tau_sd.empty());
}

TEST(Repeats, StandingStillOrDriftingIsNoMotionThatComesBack) {
  data::Dataset still = periodic(5, 20);
  still.q.setConstant(0.3);
  EXPECT_EQ(find_repeats(still).period_s, 0);
  data::Dataset ramp = periodic(5, 20);
  for (int j = 0; j < 2; ++j) ramp.q.col(j) = 0.1 * ramp.t;
  EXPECT_EQ(find_repeats(ramp).period_s, 0);
}

TEST(Repeats, MissingSamplesAreLeftOut) {
  data::Dataset d = periodic(5, 20);
  for (Eigen::Index k = 0; k < d.q.rows(); k += 7) {
    d.q(k, 0) = std::numeric_limits<double>::quiet_NaN();
    d.tau(k, 1) = std::numeric_limits<double>::quiet_NaN();
  }
  const Repeats repeats = find_repeats(d);
  EXPECT_NEAR(repeats.period_s, 5, 1e-9);
  EXPECT_NEAR(repeats.tau_sd[1], kTauNoise, 0.03 * kTauNoise);
}

TEST(Repeats, TheOtherPassageIsOnePeriodAwayAndWithinTheRecording) {
  RowMatrix tau(7, 1);
  tau << 0, 1, 2, 3, 4, 5, 6;
  const RowMatrix other = evaluate::other_passage(tau, 3);
  EXPECT_EQ(other.transpose(), (Eigen::RowVectorXd(7) << 3, 4, 5, 6, 1, 2, 3).finished());
}

/// A recording of two periods: the motion once more, the torque's noise anew.
evaluate::Trajectory twice(const evaluate::Trajectory& once, double noise) {
  evaluate::Trajectory trajectory = once;
  data::Dataset& d = trajectory.data;
  const Eigen::Index T = d.q.rows();
  const RowMatrix again = once.truth->q;
  Rng rng(8, 5);
  d.t = Eigen::VectorXd::LinSpaced(2 * T, 0, static_cast<double>(2 * T - 1) * d.dt());
  for (RowMatrix* x : {&d.q, &d.tau, &trajectory.q, &trajectory.v}) {
    const RowMatrix first = *x;
    x->resize(2 * T, first.cols());
    *x << first, first;
  }
  for (Eigen::Index j = 0; j < d.n(); ++j) {
    const double sd = noise * once.data.tau.col(j).norm() / std::sqrt(static_cast<double>(T));
    for (Eigen::Index k = T; k < 2 * T; ++k) d.tau(k, j) += std::numbers::sqrt2 * sd * rng.normal();
  }
  return trajectory;
}

// Oracle: what noise of the torque does to the true model's open loop, known here from the truth.
TEST(Repeats, FloorOfALogIsAboutTheOraclesError) {
  const double noise = 0.01;
  evaluate::Contest contest = small_contest(700, noise);
  const auto options = small_options();
  const evaluate::Evaluation with_truth = evaluate::evaluate(contest, options, 2);
  contest.models.erase(contest.models.begin());  // the oracle
  for (evaluate::Trajectory& trajectory : contest.trajectories) {
    // both passages noisy: the first as it is, the second with as much again on top of it
    trajectory = twice(trajectory, noise);
    trajectory.truth.reset();
  }
  const evaluate::Evaluation log = evaluate::evaluate(contest, options, 2);
  ASSERT_EQ(log.repeats.size(), 2u);
  for (const Repeats& repeats : log.repeats) EXPECT_NEAR(repeats.period_s, 2.8, 1e-9);
  for (std::size_t h = 0; h < 2; ++h) {
    EXPECT_GT(log.floor[h], with_truth.oracle[h] / 5) << h;
    EXPECT_LT(log.floor[h], with_truth.oracle[h] * 5) << h;
    EXPECT_EQ(log.floor[h], log.repeat[h]);
    EXPECT_EQ(log.headroom[h], log.best_conventional[h] / log.floor[h]);
  }
  EXPECT_TRUE(std::isnan(with_truth.repeat[0]));
}

}  // namespace
}  // namespace fricid::test
