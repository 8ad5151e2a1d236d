// The gradient of an open-loop window against central differences, and what trains by it.
#include "fricid/estimate/windows/windows.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "fricid/estimate/coordinates.hpp"
#include "fricid/estimate/wash_out.hpp"
#include "fricid/estimate/windows/multi_step.hpp"
#include "fricid/estimate/windows/window_refinement.hpp"
#include "fricid/system/driven_friction.hpp"
#include "fricid/system/initial_state.hpp"
#include "kr6_truth.hpp"
#include "unfiltered.hpp"

namespace fricid::estimate {
namespace {

/// A recording of the true arm, without noise.
signals::Recording record(const Arm& truth, std::uint64_t seed, int T) {
  const auto made = fricid::test::record(truth, fricid::test::HangingMotion(seed), T, {8, 1});
  return fricid::test::unfiltered("recording", fricid::test::kSamplePeriod, made.q, made.v,
                                  made.tau);
}

std::span<const double> view(const Eigen::VectorXd& x) {
  return {x.data(), static_cast<std::size_t>(x.size())};
}

/// Static friction as a fit finds it: smooth enough to be stepped without chatter.
friction::Friction smooth_friction(std::string_view law) {
  friction::Friction friction = fricid::test::kr6_friction(law);
  for (std::size_t p = 0; p < friction.theta.size(); ++p)
    if (friction.model.parameters()[p].symbol == "v0") friction.theta[p] = 0.1;
  return friction;
}

class Windows : public ::testing::TestWithParam<const char*> {
 protected:
  Arm truth{fricid::test::hanging_kr6(), smooth_friction(GetParam())};
  std::vector<signals::Recording> recordings{record(truth, 1, 700), record(truth, 2, 700)};
  std::vector<Window> windows{{0, 100}, {1, 200}, {0, 330}};
  std::vector<RowMatrix> z = wash_out(truth, recordings, 1);

  /// Loss of the windows at coordinates c; its gradient when asked.
  template <class S>
  double loss(const ArmCoordinates& coordinates, const Eigen::VectorXd& c, int steps,
              Eigen::VectorXd* gradient = nullptr) {
    Arm arm = truth;
    coordinates.apply(c, arm);
    WindowRollout<S> rollout(arm, recordings, {8, 2}, steps);
    rollout.set_parameters(view(arm.robot.pi), arm.friction.theta);
    const double value = rollout.loss(windows, z);
    if (gradient != nullptr) {
      Eigen::VectorXd pi = Eigen::VectorXd::Zero(arm.robot.pi.size());
      Eigen::VectorXd theta =
          Eigen::VectorXd::Zero(static_cast<Eigen::Index>(arm.friction.theta.size()));
      rollout.add_gradient({pi.data(), static_cast<std::size_t>(pi.size())},
                           {theta.data(), static_cast<std::size_t>(theta.size())});
      coordinates.pull_back(c, pi, theta, *gradient);
    }
    return value;
  }
};
INSTANTIATE_TEST_SUITE_P(Laws, Windows,
                         ::testing::Values("coulomb_viscous", "lugre", "gms", "maxwell_slip"));

// Four seconds of motion make every law forget where a piece began.
TEST_P(Windows, WashesOutInPiecesAsInOne) {
  const std::vector<signals::Recording> recording{record(truth, 3, 3500)};
  const signals::Recording& r = recording.front();
  const std::vector<double> z0 =
      initial_friction_state(truth, r.dt, r.wide.q, r.wide.v, r.held_tau, r.temperature);
  const RowMatrix whole =
      drive_friction(truth.friction, r.dt, r.wide.q, r.wide.v, r.held_tau, r.temperature, z0).z;
  const RowMatrix pieces = wash_out(truth, recording, 2).front();
  if (whole.cols() == 0) return;
  EXPECT_LT((whole - pieces).cwiseAbs().maxCoeff(), 1e-9 * whole.cwiseAbs().maxCoeff());
}

// Each leap is exact to rounding (system/arm_pullback_test); over a window a difference of two runs
// also sees reversals and, for gms, slip begin a sub-step earlier or later.
TEST_P(Windows, GradientEqualsCentralDifferences) {
  const std::string_view law = GetParam();
  const double tolerance = law == "lugre" || law == "gms" ? 3e-4 : 1e-6;
  const ArmCoordinates coordinates(truth, {});
  Eigen::VectorXd c = coordinates.start();
  Rng rng(3, 0);
  for (double& x : c) x += 0.01 * rng.normal();
  for (const int steps : {10, 250}) {
    Eigen::VectorXd gradient;
    loss<PackD>(coordinates, c, steps, &gradient);
    const double size = gradient.cwiseAbs().maxCoeff();
    for (Eigen::Index i = 0; i < c.size(); ++i) {
      Eigen::VectorXd step = Eigen::VectorXd::Zero(c.size());
      step[i] = 1e-6;
      const double slope =
          (loss<PackD>(coordinates, c + step, steps) - loss<PackD>(coordinates, c - step, steps)) /
          2e-6;
      EXPECT_NEAR(gradient[i], slope, tolerance * size) << "coordinate " << i << ", " << steps;
    }
  }
}

TEST_P(Windows, FloatGradientIsCloseToDouble) {
  const ArmCoordinates coordinates(truth, {});
  Eigen::VectorXd c = coordinates.start();
  Rng rng(4, 0);
  for (double& x : c) x += 0.01 * rng.normal();
  Eigen::VectorXd narrow, wide;
  const double loss_narrow = loss<PackF>(coordinates, c, 100, &narrow);
  EXPECT_NEAR(loss_narrow, loss<PackD>(coordinates, c, 100, &wide), 1e-3 * loss_narrow);
  EXPECT_LT((narrow - wide).norm(), 5e-3 * wide.norm());
}

// Where the error vanishes, v' J' W J v is the loss's second derivative along v.
TEST_P(Windows, CurvatureSamplesHaveTheCurvatureOfTheLoss) {
  constexpr int kSteps = 60, kSamples = 1500;
  const ArmCoordinates coordinates(truth, {});
  const Eigen::VectorXd c = coordinates.start();
  WindowRollout<PackD> rollout(truth, recordings, {8, 2}, kSteps);
  rollout.set_parameters(view(truth.robot.pi), truth.friction.theta);
  rollout.loss(windows, z);

  Rng rng(6, 0);
  constexpr int kDirections = 4;
  Eigen::MatrixXd directions(c.size(), kDirections);
  for (double& x : directions.reshaped()) x = rng.normal();
  Eigen::ArrayXd sum = Eigen::ArrayXd::Zero(kDirections), square = sum;
  const auto count = static_cast<Eigen::Index>(windows.size());
  Eigen::MatrixXd pi(truth.robot.pi.size(), count),
      theta(static_cast<Eigen::Index>(truth.friction.theta.size()), count);
  Eigen::VectorXd sample;
  for (int i = 0; i < kSamples; ++i) {
    rollout.curvature_samples(rng, pi, theta);
    Eigen::ArrayXd along = Eigen::ArrayXd::Zero(kDirections);
    for (Eigen::Index k = 0; k < count; ++k) {
      coordinates.pull_back(c, pi.col(k), theta.col(k), sample);
      along += (directions.transpose() * sample).array().square();
    }
    sum += along;
    square += along.square();
  }
  const Eigen::ArrayXd mean = sum / kSamples,
                       error = ((square / kSamples - mean.square()) / kSamples).sqrt();
  for (int d = 0; d < kDirections; ++d) {
    const double h = 1e-4;
    const double second = (loss<PackD>(coordinates, c + h * directions.col(d), kSteps) +
                           loss<PackD>(coordinates, c - h * directions.col(d), kSteps) -
                           2 * loss<PackD>(coordinates, c, kSteps)) /
                          (h * h);
    EXPECT_NEAR(mean[d], second, 4.5 * error[d] + 0.01 * second) << "direction " << d;
  }
}

TEST(ArmCoordinates, ApplyInvertsStart) {
  const Arm arm{fricid::test::hanging_kr6(), fricid::test::kr6_friction("gms")};
  const ArmCoordinates coordinates(arm, {});
  Arm again = arm;
  coordinates.apply(coordinates.start(), again);
  EXPECT_LT((again.robot.pi - arm.robot.pi).cwiseAbs().maxCoeff(), 1e-12);
  for (std::size_t p = 0; p < arm.friction.theta.size(); ++p)
    EXPECT_NEAR(again.friction.theta[p], arm.friction.theta[p],
                1e-12 * std::abs(arm.friction.theta[p]));
}

/// Training on a Dahl arm with bristles of 2 mrad from friction that is 30 % off.
class MultiStep : public ::testing::Test {
 protected:
  Arm truth{fricid::test::hanging_kr6(), fricid::test::kr6_friction("dahl")};
  std::vector<signals::Recording> recordings;
  Arm start;
  MultiStepOptions options;

  MultiStep() {
    for (std::size_t p = 0; p < truth.friction.theta.size(); p += 3)
      truth.friction.theta[p + 1] = truth.friction.theta[p] / 2e-3;
    recordings = {record(truth, 1, 2500), record(truth, 2, 2500)};
    start = truth;
    Rng rng(5, 0);
    for (double& x : start.friction.theta) x *= std::exp(0.3 * rng.normal());
    options.iterations = 300;
    options.window_s = 0.2;
    options.checks = 5;
  }
};

TEST_F(MultiStep, AdamRecoversFrictionFromParametersThatAreOff) {
  options.optimiser = Optimiser::kAdam;
  options.rate = 1e-2;
  const MultiStepReport report = train_multi_step(start, recordings, options, "dahl", 2);
  EXPECT_EQ(report.outcome, Outcome::kIterationLimit);
  EXPECT_LT(report.history.best_held_out(), 0.01 * report.history.held_out[0]);
  // sliding rules the error of a window; the bristles' stiffness is learned last
  for (std::size_t p = 0; p < truth.friction.theta.size(); ++p)
    EXPECT_NEAR(report.arm.friction.theta[p] / truth.friction.theta[p], 1, p % 3 == 1 ? 0.6 : 0.02)
        << truth.friction.model.parameters()[p].symbol;
}

TEST_F(MultiStep, GaussNewtonRecoversTheBristlesToo) {
  options.optimiser = Optimiser::kGaussNewton;
  options.iterations = 300;
  const MultiStepReport report = train_multi_step(start, recordings, options, "dahl", 2);
  EXPECT_LT(report.history.best_held_out(), 1e-3 * report.history.held_out[0]);
  for (std::size_t p = 0; p < truth.friction.theta.size(); ++p)
    EXPECT_NEAR(report.arm.friction.theta[p] / truth.friction.theta[p], 1, p % 3 == 1 ? 0.1 : 0.01)
        << truth.friction.model.parameters()[p].symbol;
}

// Windows do not make up for what they cannot explain by another inertia.
TEST_F(MultiStep, RefinementStaysNearTheInertiaOfTheTorque) {
  start = truth;
  const int wrist = start.robot.armature_begin() + 5;
  start.robot.pi[wrist] /= 4;
  const ArmCoordinates coordinates(start, {});
  ArmPoint point(coordinates, start);
  const Eigen::VectorXd c = point.c();
  const TorquePull nothing{c,
                           {0,
                            Eigen::VectorXd::Zero(c.size()),
                            1e-6 * Eigen::MatrixXd::Identity(c.size(), c.size()),
                            {}}};
  const MultiStepReport report = refine_on_windows(start, nothing, recordings, options, "wrist", 2);
  EXPECT_LT(report.arm.robot.pi[wrist], 1.6 * start.robot.pi[wrist]);
  // further steps would follow the rollouts to the inertia of the truth
  EXPECT_LT(std::ranges::min(report.history.held_out), 0.5 * report.history.best_held_out());
}

TEST_F(MultiStep, TakesGaussNewtonStepsUnlessTold) {
  options.iterations = 5;
  const MultiStepReport chosen = train_multi_step(start, recordings, options, "dahl", 2);
  options.optimiser = Optimiser::kGaussNewton;
  EXPECT_EQ(chosen.history.loss,
            train_multi_step(start, recordings, options, "dahl", 2).history.loss);
  options.optimiser = Optimiser::kAdam;
  EXPECT_NE(chosen.history.loss,
            train_multi_step(start, recordings, options, "dahl", 2).history.loss);
}

// a rigid bristle chatters between stick and slip at any step, and so do gradients through it
TEST_F(MultiStep, TrainsFromBristlesThatNoStepResolves) {
  for (std::size_t p = 1; p < start.friction.theta.size(); p += 3) start.friction.theta[p] = 1e8;
  options.iterations = 100;
  const MultiStepReport report = train_multi_step(start, recordings, options, "dahl", 2);
  EXPECT_EQ(report.history.skipped, 0);
  EXPECT_EQ(report.history.returns, 0);
  EXPECT_LT(report.history.best_held_out(), 0.02 * report.history.held_out[0]);
}

TEST_F(MultiStep, GoesBackAndOnWithShorterStepsWhereTheyAreTooLong) {
  options.optimiser = Optimiser::kAdam;
  options.rate = 1;
  options.checks = 10;
  const MultiStepReport report = train_multi_step(start, recordings, options, "dahl", 2);
  EXPECT_GT(report.history.returns, 0);
  EXPECT_LT(report.history.best_held_out(), 0.1 * report.history.held_out[0]);
}

TEST_F(MultiStep, KeepsAStartThatCannotBeBettered) {
  options.optimiser = Optimiser::kAdam;
  options.iterations = 20;
  options.rate = 0.3;
  const MultiStepReport report = train_multi_step(truth, recordings, options, "dahl", 2);
  EXPECT_EQ(report.history.best, 0);
  EXPECT_EQ(report.arm.friction.theta, truth.friction.theta);
}

TEST_F(MultiStep, DoesNotDependOnTheNumberOfThreads) {
  options.iterations = 30;
  for (const Optimiser optimiser : {Optimiser::kGaussNewton, Optimiser::kAdam}) {
    SCOPED_TRACE(name_of(optimiser));
    options.optimiser = optimiser;
    const MultiStepReport one = train_multi_step(start, recordings, options, "dahl", 1);
    const MultiStepReport three = train_multi_step(start, recordings, options, "dahl", 3);
    EXPECT_EQ(one.history.loss, three.history.loss);
    EXPECT_EQ(one.history.held_out, three.history.held_out);
    EXPECT_EQ(one.arm.friction.theta, three.arm.friction.theta);
  }
}

}  // namespace
}  // namespace fricid::estimate
