// External torque of arms whose truth is known: the engine adds a torque that the log does not say.
#include "fricid/estimate/contact/momentum_observer.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "fricid/base/error.hpp"
#include "fricid/base/not_finite.hpp"
#include "fricid/base/rng.hpp"
#include "fricid/estimate/contact/contact_log.hpp"
#include "kr6_truth.hpp"

namespace fricid::estimate {
namespace {

using fricid::test::hanging_kr6;
using fricid::test::HangingMotion;
using fricid::test::kr6_friction;
using fricid::test::kSamplePeriod;

constexpr double kBandwidth = 10;  // [Hz]
constexpr int kSettled = 100;      // samples after which an observer knows its torque

/// A log in which `truth` moves and `external` (n) acts from sample `from`.
data::Dataset pushed(const Arm& truth, const Eigen::RowVectorXd& external, int from, int T = 1500) {
  const test::Recording recording = test::record(truth, HangingMotion(3), T, {8});
  data::Dataset log;
  log.joint_names = {"a1", "a2", "a3", "a4", "a5", "a6"};
  log.rate_hz = 1 / kSamplePeriod;
  log.t = Eigen::VectorXd::LinSpaced(T, 0, (T - 1) * kSamplePeriod);
  log.q = recording.q;
  log.tau = recording.tau;
  // the motor gives less than what moves the arm: the rest comes from outside
  log.tau.bottomRows(T - from).rowwise() -= external;
  return log;
}

data::ContactSignals observe(const Arm& model, const data::Dataset& log) {
  return observe_log({.name = "model", .label = "model", .arm = model}, log,
                     {.bandwidth_hz = kBandwidth});
}

/// What the observer of `model` finds in it.
RowMatrix observed(const Arm& truth, const Arm& model, const Eigen::RowVectorXd& external,
                   int from) {
  return observe(model, pushed(truth, external, from)).tau_ext;
}

const Eigen::RowVectorXd kNothing = Eigen::RowVectorXd::Zero(6),
                         kPush = (Eigen::RowVectorXd(6) << 8, -12, 5, 2, -1, 0.5).finished();

TEST(MomentumObserver, SeesNothingWhereNothingIs) {
  for (const char* law : {"lugre", "gms", "maxwell_slip"}) {
    const Arm arm{hanging_kr6(), kr6_friction(law)};
    const RowMatrix found = observed(arm, arm, kNothing, 0);
    EXPECT_LT(found.bottomRows(1000).cwiseAbs().maxCoeff(), 0.25) << law;
  }
}

// r is the torque behind a low-pass and one sample of delay, whatever the arm does.
TEST(MomentumObserver, IsALowPassOfTheExternalTorque) {
  const Arm arm{hanging_kr6(), kr6_friction("gms")};
  constexpr int kFrom = 700;
  const RowMatrix change = observed(arm, arm, kPush, kFrom) - observed(arm, arm, kNothing, kFrom);
  EXPECT_EQ(change.middleRows(kSettled, kFrom - kSettled).cwiseAbs().maxCoeff(), 0);
  // the first step of the low-pass sees half of it, since momentum is that of the middle of samples
  const double kept = std::exp(-2 * std::numbers::pi * kBandwidth * kSamplePeriod);
  for (const int samples : {0, 1, 5, 10, 60}) {
    const double share = 1 - std::pow(kept, samples) * (1 + kept) / 2;
    for (int j = 0; j < 6; ++j)
      EXPECT_NEAR(change(kFrom + 1 + samples, j) / kPush[j], share, 1e-9)
          << "joint " << j << " after " << samples;
  }
}

// What is faster than half the sample rate is no low-pass.
TEST(MomentumObserver, IsNoFasterThanHalfTheRate) {
  const Arm arm{hanging_kr6(), kr6_friction("gms")};
  const data::ModelFile model{.name = "model", .label = "model", .arm = arm};
  const data::Dataset log = pushed(arm, kPush, 700);
  EXPECT_NO_THROW(observe_log(model, log, {.bandwidth_hz = log.rate_hz / 2}));
  EXPECT_THROW(observe_log(model, log, {.bandwidth_hz = 0.6 * log.rate_hz}), UserError);
}

// Behind missing samples it begins anew; until it has settled nothing is known.
TEST(MomentumObserver, LeavesOutGapsAndSettlesBehindThem) {
  const Arm arm{hanging_kr6(), kr6_friction("gms")};
  const data::Dataset whole = pushed(arm, kPush, 700);
  const RowMatrix expected = observe(arm, whole).tau_ext;
  constexpr int kBegin = 1000, kEnd = 1025;
  for (RowMatrix data::Dataset::*signal : {&data::Dataset::q, &data::Dataset::tau}) {
    data::Dataset log = whole;
    (log.*signal).block(kBegin, 1, kEnd - kBegin, 1).setConstant(kNan);
    const data::ContactSignals found = observe(arm, log);
    // the noise of the encoders is that of what is there
    EXPECT_LT(
        (found.tau_ext - expected).middleRows(kSettled, kBegin - kSettled).cwiseAbs().maxCoeff(),
        1e-3);
    for (const RowMatrix* x : {&found.tau_ext, &found.tau_f})
      EXPECT_TRUE(x->middleRows(kBegin + 1, kEnd - kBegin).array().isNaN().all());
    EXPECT_TRUE(found.tau_ext.bottomRows(found.tau_ext.rows() - kEnd - kSettled).allFinite());
    for (int k = kEnd; k < expected.rows(); ++k)
      for (int j = 0; j < 6; ++j)
        if (std::isfinite(found.tau_ext(k, j))) {
          ASSERT_NEAR(found.tau_ext(k, j), expected(k, j), 0.02 * std::abs(kPush[j]) + 0.25)
              << "joint " << j << " at sample " << k;
        }
  }
}

// A log that lacks its first samples begins behind them.
TEST(MomentumObserver, BeginsWhereALogIsWhole) {
  const Arm arm{hanging_kr6(), kr6_friction("gms")};
  const data::Dataset whole = pushed(arm, kPush, 700);
  constexpr int kMissing = 5;
  data::Dataset log = whole;
  log.q.topRows(kMissing).col(1).setConstant(kNan);
  data::Dataset rest = whole;
  for (RowMatrix data::Dataset::*signal : {&data::Dataset::q, &data::Dataset::tau})
    rest.*signal = RowMatrix((whole.*signal).bottomRows(whole.length() - kMissing));
  rest.t = whole.t.tail(whole.length() - kMissing).eval();
  const RowMatrix found = observe(arm, log).tau_ext, expected = observe(arm, rest).tau_ext;
  EXPECT_TRUE(found.topRows(kMissing).array().isNaN().all());
  for (int k = 0; k < expected.rows(); ++k)
    for (int j = 0; j < 6; ++j) {
      ASSERT_EQ(std::isnan(found(kMissing + k, j)), std::isnan(expected(k, j))) << k << " " << j;
      if (!std::isnan(expected(k, j))) {
        ASSERT_NEAR(found(kMissing + k, j), expected(k, j), 1e-2) << k << " " << j;
      }
    }
}

// What friction holds as a log begins is in no log: in an arm at rest it is what the torque is
// beside gravity, and in the steps of an encoder nothing of it is lost.
TEST(MomentumObserver, FeelsNothingWhereAnArmStands) {
  const Arm arm{hanging_kr6(), kr6_friction("lugre")};
  data::Dataset log = pushed(arm, kNothing, 0);
  log.q.rowwise() = Eigen::RowVectorXd(log.q.row(0));
  Rng rng(1, 0);
  for (double& q : log.q.reshaped()) q = 1e-5 * std::round((q + 5e-6 * rng.normal()) / 1e-5);
  const std::vector<double> zero(6);
  std::vector<double> gravity(6);
  dynamics::Workspace<double> ws(arm.robot);
  dynamics::rnea<double>(arm.robot, ws,
                         {arm.robot.pi.data(), static_cast<std::size_t>(arm.robot.pi.size())},
                         {log.q.row(0).data(), 6}, zero, zero, gravity);
  log.tau.rowwise() = Eigen::Map<const Eigen::RowVectorXd>(gravity.data(), 6) + 0.5 * kPush;
  const RowMatrix found = observe(arm, log).tau_ext;
  for (int j = 0; j < 6; ++j)
    EXPECT_LT(found.col(j).tail(1000).cwiseAbs().maxCoeff(), 0.2 * std::abs(kPush[j])) << j;
}

// A push on an arm that stands moves nothing that friction would not.
TEST(MomentumObserver, WithParticlesFeelsAPushAtRest) {
  const Arm arm{hanging_kr6(), kr6_friction("lugre")};
  data::Dataset log = pushed(arm, kNothing, 0);
  constexpr int kPushed = 1000;
  log.q.rowwise() = Eigen::RowVectorXd(log.q.row(0));
  const auto n = static_cast<std::size_t>(arm.robot.n());
  dynamics::Workspace<double> ws(arm.robot);
  const std::vector<double> zero(n);
  std::vector<double> gravity(n);
  dynamics::rnea<double>(arm.robot, ws,
                         {arm.robot.pi.data(), static_cast<std::size_t>(arm.robot.pi.size())},
                         {log.q.row(0).data(), n}, zero, zero, gravity);
  log.tau.rowwise() = Eigen::Map<const Eigen::RowVectorXd>(gravity.data(), log.tau.cols());
  log.tau.bottomRows(log.length() - kPushed).rowwise() -= kPush;
  const LatentNoise noise{.dt = kSamplePeriod,
                          .q = Eigen::VectorXd::Constant(6, 1e-12),
                          .v = Eigen::VectorXd::Constant(6, 1e-8),
                          .z = Eigen::VectorXd::Constant(6, 1e-12),
                          .R = Eigen::VectorXd::Constant(6, 1.6e-11),
                          .friction = Eigen::VectorXd::Constant(6, 1e-4)};
  const data::ModelFile model{.name = "model", .label = "model", .arm = arm, .noise = noise};
  const RowMatrix found =
      observe_log(model, log, {.bandwidth_hz = kBandwidth, .particles = 50}).tau_ext;
  for (int j = 0; j < 6; ++j)
    EXPECT_NEAR(found(found.rows() - 1, j), kPush[j], 0.02 * std::abs(kPush[j])) << j;
}

// Wrong friction is a contact that is not there.
TEST(MomentumObserver, TakesWrongFrictionForContact) {
  const Arm truth{hanging_kr6(), kr6_friction("maxwell_slip")},
      model{hanging_kr6(), kr6_friction("coulomb_viscous")};
  EXPECT_GT(observed(truth, model, kNothing, 0).bottomRows(1000).cwiseAbs().maxCoeff(), 3);
}

TEST(MomentumObserver, RefusesALogOfOtherJoints) {
  data::ModelFile model{
      .name = "model", .label = "model", .arm = {hanging_kr6(), kr6_friction("gms")}};
  data::Dataset log;
  log.name = "short";
  log.q = log.tau = RowMatrix::Zero(3, 2);
  log.joint_names = {"a", "b"};
  log.t = Eigen::Vector3d(0, 1, 2);
  EXPECT_THROW(observe_log(model, log, {}), UserError);
}

}  // namespace
}  // namespace fricid::estimate
