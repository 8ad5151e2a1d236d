#include "fricid/sim/closed_loop.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "arms.hpp"
#include "fricid/sim/simulate.hpp"

namespace fricid::sim::test {
namespace {

/// A scene of short paths under computed torque.
scene::Problem problem() {
  scene::Scene small = small_scene("kr6_gms");
  small.controller.kind = ControlLaw::kComputedTorque;
  small.controller.bandwidth_hz = 4;
  return resolve(small);
}

LoopTask task_of(const scene::Problem& problem, const MujocoArm& arm, double size = 0.3) {
  return {.path = random_path(problem, arm, 0, size), .controller = problem.scene.controller};
}

FeedForward truth_of(const scene::Problem& problem, double gain = 1) {
  return {.friction = *problem.scene.friction,
          .constant = Eigen::VectorXd::Zero(problem.robot.n()),
          .gain = gain};
}

double rms_error(const data::LoopSignals& loop) {
  return std::sqrt((loop.q - loop.q_desired).cwiseAbs2().mean());
}

TEST(ClosedLoop, TheTrueFrictionFedForwardLeavesLittleError) {
  const scene::Problem p = problem();
  const MujocoArm arm = make_arm(p);
  LoopTask task = task_of(p, arm);
  const double bare = rms_error(simulate_loop(p, arm, task));
  for (const Drive drive : {Drive::kReference, Drive::kMeasured}) {
    task.forward = truth_of(p);
    task.forward->drive = drive;
    const double fed = rms_error(simulate_loop(p, arm, task));
    std::printf("%s: %.3g of %.3g rad\n", std::string(name_of(drive)).c_str(), fed, bare);
    EXPECT_LT(fed, bare / 5) << name_of(drive);
  }
}

TEST(ClosedLoop, TorqueIsThatOfTheControllerAndTheFrictionWithinTheLimits) {
  const scene::Problem p = problem();
  const MujocoArm arm = make_arm(p);
  LoopTask task = task_of(p, arm);
  task.forward = truth_of(p, 0);
  const data::LoopSignals with_zero = simulate_loop(p, arm, task);
  task.forward.reset();
  EXPECT_EQ(simulate_loop(p, arm, task).q, with_zero.q) << "a gain of 0 feeds nothing forward";

  // motors too weak for the peaks of the path
  scene::Problem weak = p;
  for (int j = 0; j < p.robot.n(); ++j)
    weak.robot.joints[static_cast<std::size_t>(j)].effort =
        0.9 * with_zero.tau.col(j).cwiseAbs().maxCoeff();
  task.forward = truth_of(p);
  const data::LoopSignals limited = simulate_loop(weak, arm, task);
  ASSERT_GT(limited.tau.rows(), 0);
  for (int j = 0; j < p.robot.n(); ++j)
    EXPECT_EQ(limited.tau.col(j).cwiseAbs().maxCoeff(),
              weak.robot.joints[static_cast<std::size_t>(j)].effort)
        << j;
}

TEST(ClosedLoop, RestsAtTheEndOfThePath) {
  const scene::Problem p = problem();
  const MujocoArm arm = make_arm(p);
  LoopTask task = task_of(p, arm);
  task.rest_s = 1.5;
  const data::LoopSignals loop = simulate_loop(p, arm, task);
  const auto rest = static_cast<Eigen::Index>(1.4 * p.scene.sensors.rate_hz);
  EXPECT_LT(loop.v_desired.bottomRows(rest).cwiseAbs().maxCoeff(), 1e-9);
  EXPECT_LT(loop.v.bottomRows(10).cwiseAbs().maxCoeff(), 1e-3);
  EXPECT_NEAR(loop.t[loop.t.size() - 1], task.path.period() + 1.5, 0.01);
}

// Two forces that differ by a factor: so do their torques, which are zero before and after.
TEST(ClosedLoop, PushesActWhileTheyLast) {
  const scene::Problem p = problem();
  const MujocoArm arm = make_arm(p);
  LoopTask task = task_of(p, arm);
  task.pushes = {{.begin = 300, .end = 350, .joint = 4, .force = {0, 0, 20}}};
  const data::LoopSignals loop = simulate_loop(p, arm, task);
  EXPECT_EQ(loop.tau_ext.topRows(300).cwiseAbs().maxCoeff(), 0);
  EXPECT_EQ(loop.tau_ext.bottomRows(loop.tau_ext.rows() - 350).cwiseAbs().maxCoeff(), 0);
  EXPECT_GT(loop.tau_ext.row(320).cwiseAbs().maxCoeff(), 0.5);
  EXPECT_EQ(loop.tau_ext(320, 5), 0) << "the last joint does not carry the pushed link";
  const data::Dataset log = log_of(loop, p, 0);
  EXPECT_EQ(log.q, loop.q_measured);
  EXPECT_LT((log.q - loop.q).cwiseAbs().maxCoeff(), 1e-4);
  EXPECT_LT((log.tau - loop.tau).cwiseAbs().maxCoeff(), 1);
}

TEST(ClosedLoop, EndsWhenTheArmIsLost) {
  const scene::Problem p = problem();
  const MujocoArm arm = make_arm(p);
  LoopTask task = task_of(p, arm);
  task.forward = truth_of(p, 10);
  task.forward->drive = Drive::kMeasured;
  task.controller.bandwidth_hz = 0.1;
  EXPECT_LT(static_cast<double>(simulate_loop(p, arm, task).t.size()),
            task.path.period() * p.scene.sensors.rate_hz - 1);
}

}  // namespace
}  // namespace fricid::sim::test
