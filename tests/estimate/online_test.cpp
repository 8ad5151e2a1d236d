// The online estimator on a recording of an arm whose truth is known.
#include "fricid/estimate/online/online.hpp"

#include <gtest/gtest.h>

#include <Eigen/LU>

#include "fit_of_logs.hpp"
#include "fricid/base/rng.hpp"
#include "fricid/estimate/online/online_log.hpp"
#include "fricid/estimate/online/online_state.hpp"
#include "fricid/system/driven_friction.hpp"
#include "kr6_truth.hpp"
#include "malloc_counter.hpp"

namespace fricid::estimate {
namespace {

constexpr int kSamples = 600;
constexpr double kEncoderNoise = 4e-6;  // [rad]
constexpr double kTorqueNoise = 0.05;   // [N m]

class Online : public ::testing::Test {
 protected:
  Arm arm{fricid::test::hanging_kr6(), fricid::test::kr6_friction("lugre")};
  fricid::test::Recording truth =
      fricid::test::record(arm, fricid::test::HangingMotion(3), kSamples, {8, 4});
  RowMatrix y = truth.q, tau = truth.tau;
  LatentNoise noise;
  smc::Gaussian start;

  Online() {
    Rng rng(1, 0);
    for (double& q : y.reshaped()) q += kEncoderNoise * rng.normal();
    for (double& u : tau.reshaped()) u += kTorqueNoise * rng.normal();
    const Eigen::Index n = 6, nz = arm.friction.model.state_size();
    noise.dt = fricid::test::kSamplePeriod;
    noise.R = Eigen::VectorXd::Constant(n, kEncoderNoise * kEncoderNoise);
    noise.q = 0.06 * noise.R;
    dynamics::Workspace<double> ws(arm.robot);
    Eigen::MatrixXd M(n, n);
    dynamics::crba<double>(arm.robot, ws,
                           {arm.robot.pi.data(), static_cast<std::size_t>(arm.robot.pi.size())},
                           row(truth.q, 0), {M.data(), 36});
    noise.v = (2 * kTorqueNoise * noise.dt * M.inverse().diagonal()).cwiseAbs2();
    noise.z = Eigen::VectorXd::Constant(nz, 1e-12);
    start = online_start(truth.q.row(0), truth.v.row(0), truth.z.row(0), noise, 1e-3,
                         Eigen::VectorXd::Constant(nz, 1e-5));
  }

  static std::span<const double> row(const RowMatrix& x, int t) {
    return {x.row(t).data(), static_cast<std::size_t>(x.cols())};
  }
  const OnlineEstimate& step(OnlineEstimator& estimator, int t) {
    return estimator.step(row(tau, t), row(y, t + 1));
  }
};

TEST_F(Online, FollowsStatesAndFriction) {
  OnlineEstimator estimator(arm, noise, start, {});
  double error = 0, size = 0, q_error = 0;
  for (int t = 0; t + 1 < kSamples; ++t) {
    const OnlineEstimate& now = step(estimator, t);
    ASSERT_FALSE(now.lost) << "sample " << t;
    q_error += (now.q - truth.q.row(t + 1).transpose()).squaredNorm() / (6 * (kSamples - 1));
    if (t < 50) continue;
    error += (now.tau_f - truth.tau_f.row(t + 1).transpose()).squaredNorm();
    size += truth.tau_f.row(t + 1).squaredNorm();
  }
  EXPECT_LT(std::sqrt(q_error), kEncoderNoise);
  EXPECT_LT(std::sqrt(error / size), 0.05);
  EXPECT_TRUE(std::isfinite(estimator.estimate().log_likelihood));
}

// What the law leaves says by how much it errs; the spread of its particles does not.
TEST_F(Online, BandsHoldTheFrictionOfALawThatErrs) {
  Arm weak = arm;  // by a tenth
  for (std::size_t p = 0; p < weak.friction.theta.size(); ++p) {
    const friction::Role role = weak.friction.model.parameters()[p].info.role;
    if (friction::is_torque(role)) weak.friction.theta[p] *= 0.9;
  }
  const Eigen::ArrayXd error = 0.1 * truth.tau_f.array().square().colwise().mean().sqrt();
  noise.v.array() *= (error / (2 * kTorqueNoise)).square();
  noise.friction = error.square();
  OnlineEstimator estimator(weak, noise, start, {});
  Eigen::ArrayXd held = Eigen::ArrayXd::Zero(6), variance = held, square = held;
  for (int t = 0; t + 1 < kSamples; ++t) {
    const OnlineEstimate& now = step(estimator, t);
    const Eigen::ArrayXd e = (now.tau_f - truth.tau_f.row(t + 1).transpose()).array();
    held += (e.abs() < 1.645 * now.tau_f_sd.array()).cast<double>() / (kSamples - 1);
    square += e.square();
    variance += now.tau_f_sd.array().square();
  }
  EXPECT_GT(held.minCoeff(), 0.8) << held.transpose();
  EXPECT_LT((variance / square).maxCoeff(), 4) << (variance / square).transpose();
}

// Friction states that are wrong by twice their size push the arm far from where it goes.
TEST_F(Online, ComesBackToTheMeasuredMotionWhereItIsLost) {
  start.mean.tail(noise.z.size()).setConstant(-5e-3);
  OnlineEstimator estimator(arm, noise, start, {});
  int lost = 0, last = 0;
  double off = 0;
  for (int t = 0; t + 1 < kSamples; ++t) {
    const OnlineEstimate& now = step(estimator, t);
    lost += now.lost;
    if (now.lost) last = t;
    if (t >= kSamples / 2)
      off = std::max(off, (now.v - truth.v.row(t + 1).transpose()).cwiseAbs().maxCoeff());
  }
  EXPECT_GT(lost, 0);
  EXPECT_LT(last, kSamples / 4);
  EXPECT_LT(off, 0.02);
}

TEST_F(Online, BridgesMissingSamplesAndSaysSoByItsBand) {
  OnlineEstimator estimator(arm, noise, start, {});
  for (int t = 0; t < 200; ++t) step(estimator, t);
  const double known = estimator.estimate().q_sd[0];
  const std::vector<double> nothing(6, std::nan(""));
  for (int t = 200; t < 220; ++t) estimator.step(row(tau, t), nothing);
  EXPECT_GT(estimator.estimate().q_sd[0], 3 * known);
  for (int t = 220; t < 260; ++t) step(estimator, t);
  EXPECT_LT(estimator.estimate().q_sd[0], 2 * known);
  EXPECT_NEAR(estimator.estimate().q[0], truth.q(260, 0), 5 * kEncoderNoise);
}

TEST_F(Online, DoesNotAllocate) {
  OnlineEstimator estimator(arm, noise, start, {});
  OnlineEstimator::State state;
  estimator.save(state);
  const auto before = smc::test::heap_blocks();
  for (int t = 0; t < 200; ++t) step(estimator, t);
  estimator.save(state);
  estimator.restore(state);
  EXPECT_EQ(smc::test::heap_blocks(), before);
}

TEST_F(Online, GoesOnFromASavedStateToTheLastBit) {
  OnlineEstimator estimator(arm, noise, start, {}), other(arm, noise, start, {});
  for (int t = 0; t < 100; ++t) step(estimator, t);
  OnlineEstimator::State state;
  estimator.save(state);
  for (int t = 100; t < 150; ++t) step(estimator, t);
  other.restore(state);
  for (int t = 100; t < 150; ++t) step(other, t);
  EXPECT_EQ(estimator.estimate().tau_f, other.estimate().tau_f);
  EXPECT_EQ(estimator.estimate().q_sd, other.estimate().q_sd);
  EXPECT_EQ(estimator.estimate().log_likelihood, other.estimate().log_likelihood);
}

// Nor do the positions measured last get lost, from which a lost filter takes its velocity.
TEST_F(Online, GoesOnFromASavedStateWhereItIsLost) {
  start.mean.tail(noise.z.size()).setConstant(-5e-3);
  OnlineEstimator estimator(arm, noise, start, {}), other(arm, noise, start, {});
  OnlineEstimator::State state;
  int t = 0;
  do estimator.save(state);
  while (!step(estimator, t++).lost);
  for (int k = 0; k < 100; ++k) step(other, k);
  other.restore(state);
  step(other, t - 1);
  EXPECT_EQ(estimator.estimate().v, other.estimate().v);
}

// A log of the arm that was fitted, by another motion.
TEST(Estimates, BandsOfAFitHoldTheMotionAndTheFriction) {
  const Arm truth = lugre_arm();
  LogOptions options{.torque_noise = 0.05, .encoder_noise = 5e-6, .seed = 1};
  std::vector<data::Dataset> logs{make_log(truth, options)};
  options.seed = 2;
  logs.push_back(make_log(truth, options));
  const Prepared prepared = prepare(truth.robot, {}, logs, 2);
  ConventionalFits conventional(prepared);
  for (const std::string law : {"coulomb_viscous", "lugre"}) {
    ModelOptions config = model_of_one_start(law);
    config.law = law;
    const FitReport fitted = fit_model(conventional, config, 1, 2);
    options.seed = 3;
    const OnlineLog found = estimate_log(fitted.model, make_log(truth, options), {});
    const data::Dataset exact = make_log(truth, {.seed = 3});
    const double dt = exact.dt();
    const Eigen::Index T = exact.q.rows(), n = exact.q.cols(), begin = 100;
    RowMatrix v = RowMatrix::Zero(T, n);
    v.middleRows(1, T - 2) = (exact.q.bottomRows(T - 2) - exact.q.topRows(T - 2)) / (2 * dt);
    const RowMatrix tau_f =
        drive_friction(truth.friction, dt, exact.q, v, exact.tau, RowMatrix()).tau_f;
    const auto held = [&](const RowMatrix& mean, const RowMatrix& sd, const RowMatrix& true_one) {
      const auto z = ((mean - true_one).array() / sd.array()).middleRows(begin, T - 2 * begin);
      return (z.abs() < 1.645).cast<double>().mean();
    };
    for (const double share : {held(found.q, found.q_sd, exact.q), held(found.v, found.v_sd, v),
                               held(found.tau_f, found.tau_f_sd, tau_f)}) {
      EXPECT_GT(share, 0.85) << law;
      EXPECT_LT(share, 0.999) << law;
    }
    EXPECT_LT(found.lost, 10) << law;
  }
}

TEST_F(Online, ResetBeginsAgain) {
  OnlineEstimator estimator(arm, noise, start, {});
  for (int t = 0; t < 20; ++t) step(estimator, t);
  const double first = estimator.estimate().log_likelihood;
  estimator.reset();
  for (int t = 0; t < 20; ++t) step(estimator, t);
  EXPECT_EQ(estimator.estimate().log_likelihood, first);
}

}  // namespace
}  // namespace fricid::estimate
