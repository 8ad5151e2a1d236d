#include "fricid/evaluate/metrics.hpp"
#include "fricid/base/not_finite.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace fricid::evaluate {
namespace {

RowMatrix matrix(Eigen::Index rows, Eigen::Index cols, std::initializer_list<double> values) {
  RowMatrix m(rows, cols);
  std::copy(values.begin(), values.end(), m.data());
  return m;
}

/// Two joints that should stand at zero, six samples.
Trajectory still() {
  Trajectory trajectory;
  trajectory.data.rate_hz = 250;
  trajectory.data.q = trajectory.q = trajectory.v = RowMatrix::Zero(6, 2);
  return trajectory;
}

// Errors of joint 1: 0 1 2, of joint 2: 0 -3 0.
TEST(HorizonError, MseAndMaeByHand) {
  const Rollout rollout{
      {0, 2, 2}, false, matrix(3, 2, {0, 0, 1, -3, 2, 0}), matrix(3, 2, {0, 0, 0, 0, 6, 0}), {}};
  const HorizonError e = horizon_error(rollout, still(), 2);
  EXPECT_DOUBLE_EQ(e.q_mse_joint[0], 5.0 / 3);
  EXPECT_DOUBLE_EQ(e.q_mse_joint[1], 9.0 / 3);
  EXPECT_DOUBLE_EQ(e.q_mae_joint[0], 1.0);
  EXPECT_DOUBLE_EQ(e.q_mae_joint[1], 1.0);
  EXPECT_DOUBLE_EQ(e.q_mse, 14.0 / 6);
  EXPECT_DOUBLE_EQ(e.q_mae, 1.0);
  EXPECT_DOUBLE_EQ(e.v_mse_joint[0], 12.0);
  EXPECT_DOUBLE_EQ(e.v_mse, 6.0);
  EXPECT_DOUBLE_EQ(e.v_mae, 1.0);
}

TEST(HorizonError, PoolsOnlyTheSamplesUpToTheHorizon) {
  const Rollout rollout{
      {0, 2, 2}, false, matrix(3, 2, {0, 0, 1, -3, 2, 0}), RowMatrix::Zero(3, 2), {}};
  EXPECT_DOUBLE_EQ(horizon_error(rollout, still(), 1).q_mse, 10.0 / 4);
  EXPECT_DOUBLE_EQ(horizon_error(rollout, still(), 0).q_mse, 0);
}

TEST(HorizonError, LongerThanTheRolloutDoesNotExist) {
  const Rollout rollout{{0, 0, 2}, false, RowMatrix::Zero(3, 2), RowMatrix::Zero(3, 2), {}};
  const HorizonError e = horizon_error(rollout, still(), 3);
  EXPECT_TRUE(std::isnan(e.q_mse));
  EXPECT_TRUE(std::isnan(e.v_mae_joint[1]));
}

TEST(HorizonError, ComparesWithTheReferenceAtItsOwnTime) {
  Trajectory trajectory = still();
  trajectory.data.q = matrix(6, 2, {0, 0, 1, 10, 2, 20, 3, 30, 4, 40, 5, 50});
  const Rollout rollout{
      {0, 3, 2}, false, matrix(3, 2, {3, 30, 4, 40, 5, 51}), RowMatrix::Zero(3, 2), {}};
  const HorizonError e = horizon_error(rollout, trajectory, 2);
  EXPECT_DOUBLE_EQ(e.q_mse_joint[0], 0);
  EXPECT_DOUBLE_EQ(e.q_mse_joint[1], 1.0 / 3);
}

TEST(HorizonError, ScoresTruthRatherThanMeasurementAndSkipsGaps) {
  Trajectory trajectory = still();
  trajectory.data.q(1, 0) = kNan;
  const Rollout rollout{{0, 0, 2}, false, RowMatrix::Constant(3, 2, 2), RowMatrix::Zero(3, 2), {}};
  EXPECT_DOUBLE_EQ(horizon_error(rollout, trajectory, 2).q_mse_joint[0], 4);
  trajectory.truth = Reference{RowMatrix::Constant(6, 2, 1), RowMatrix::Zero(6, 2), {}, {}};
  EXPECT_DOUBLE_EQ(horizon_error(rollout, trajectory, 2).q_mse, 1);
}

const std::vector<dynamics::Joint> kTurning(1);

/// One joint, q = 0.1 sin 2 pi t for one second at 250 Hz: reversals at 0.25 and 0.75 s.
Trajectory swinging() {
  Trajectory trajectory;
  trajectory.data.rate_hz = 250;
  Reference truth{RowMatrix(250, 1), RowMatrix(250, 1), RowMatrix::Zero(250, 1), {}};
  const double w = 2 * std::numbers::pi;
  for (Eigen::Index k = 0; k < 250; ++k) {
    const double t = 0.004 * (static_cast<double>(k) + 0.5);
    truth.q(k, 0) = 0.1 * std::sin(w * t);
    truth.v(k, 0) = 0.1 * w * std::cos(w * t);
  }
  trajectory.truth = truth;
  return trajectory;
}

// An error that is 1 in a window of 0.05 s on both sides of the reversals, 2 elsewhere.
TEST(MeanAbsoluteError, IsTheMeanOverJointsOfEachSample) {
  const RowMatrix q = matrix(2, 2, {1, -3, 0, 0.5}), reference = matrix(3, 2, {0, 0, 0, 0, 9, 9});
  EXPECT_EQ(mean_absolute_error(q, reference), Eigen::Vector2d(2, 0.25));
}

TEST(RegimeError, ReversalIsATenthOfASecondAroundAChangeOfSign) {
  const Trajectory trajectory = swinging();
  RowMatrix tau_f = RowMatrix::Constant(250, 1, 2);
  for (const int reversal : {62, 187}) tau_f.middleRows(reversal - 12, 26).setConstant(1);
  const RegimeError e = friction_error(tau_f, trajectory, 0, kTurning);
  EXPECT_NEAR(e.reversal[0], 1, 1e-15);
  EXPECT_NEAR(e.sliding[0], 2, 1e-15);  // presliding lies within the window, but for the start
}

// After a reversal, 5 mrad of travel take acos(0.95)/w = 50.5 ms; before it, |v| < 0.05 lasts 12.7
// ms.
TEST(RegimeError, PreslidingIsSlowOrShortlyAfterAReversal) {
  const Trajectory trajectory = swinging();
  RowMatrix tau_f = RowMatrix::Zero(250, 1);
  for (Eigen::Index k = 0; k < 250; ++k) {
    const double t = 0.004 * (static_cast<double>(k) + 0.5);
    const auto slow = [&](double reversal) {
      return t > reversal - 0.0127 && t < reversal + 0.0505;
    };
    if (t < 0.008 || slow(0.25) || slow(0.75)) tau_f(k, 0) = 3;  // 5 mrad from where it began
  }
  const RegimeError e = friction_error(tau_f, trajectory, 0, kTurning);
  EXPECT_NEAR(e.presliding[0], 3, 1e-15);
  EXPECT_EQ(e.sliding[0], 0);
}

// The same motion in metres counts as sliding but for a tenth of that travel: acos(0.995)/w = 15.9
// ms.
TEST(RegimeError, OfASlidingJointHasShorterLengths) {
  std::vector<dynamics::Joint> sliding(1);
  sliding[0].type = dynamics::JointType::kPrismatic;
  const Trajectory trajectory = swinging();
  RowMatrix tau_f = RowMatrix::Zero(250, 1);
  for (Eigen::Index k = 0; k < 250; ++k) {
    const double t = 0.004 * (static_cast<double>(k) + 0.5);
    for (const double reversal : {0.25, 0.75})
      if (t > reversal - 0.0013 && t < reversal + 0.0161) tau_f(k, 0) = 3;
    if (k == 0) tau_f(k, 0) = 3;
  }
  const RegimeError e = friction_error(tau_f, trajectory, 0, sliding);
  EXPECT_NEAR(e.presliding[0], 3, 1e-15);
  EXPECT_LT(friction_error(tau_f, trajectory, 0, kTurning).presliding[0], 2);
}

TEST(RegimeError, WindowsCountFromTheirBeginning) {
  const Trajectory trajectory = swinging();
  const RegimeError sliding =
      friction_error(RowMatrix::Constant(10, 1, 4), trajectory, 20, kTurning);
  EXPECT_DOUBLE_EQ(sliding.all[0], 4);
  EXPECT_DOUBLE_EQ(sliding.sliding[0], 4);
  EXPECT_TRUE(std::isnan(sliding.reversal[0]));
  const RegimeError reversal =
      friction_error(RowMatrix::Constant(10, 1, 4), trajectory, 58, kTurning);
  EXPECT_DOUBLE_EQ(reversal.reversal[0], 4);
  EXPECT_TRUE(std::isnan(reversal.sliding[0]));
}

}  // namespace
}  // namespace fricid::evaluate
