#include "fricid/viewer/live_arm.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "fricid/sim/simulate.hpp"
#include "source_dir.hpp"

namespace fricid::viewer {
namespace {

class LiveArmTest : public ::testing::Test {
 protected:
  scene::Problem problem = scene::load_problem(source_dir() / "scenes/kr6_lugre.toml");
  sim::MujocoArm arm = sim::make_arm(problem);
  LiveArm live{arm, problem, *problem.scene.friction};

  double moved(int joint) const {
    return live.state().q[static_cast<std::size_t>(joint)] -
           problem.scene.excitation.centre[static_cast<std::size_t>(joint)];
  }
  void run(double seconds) {
    const double end = live.time() + seconds;
    while (live.time() < end - 1e-9) live.step();
  }
  int parameter(int joint, const std::string& symbol) const {
    const auto& parameters = live.friction().model.parameters();
    const auto found = std::find_if(parameters.begin(), parameters.end(), [&](const auto& p) {
      return p.joint == joint && p.symbol == symbol;
    });
    return static_cast<int>(found - parameters.begin());
  }
};

TEST_F(LiveArmTest, StandsStillUntilItIsPushed) {
  run(1);
  for (int j = 0; j < 6; ++j) EXPECT_NEAR(moved(j), 0, 1e-6) << j;
}

TEST_F(LiveArmTest, APushBelowFrictionOnlyBendsTheBristles) {
  // Fc of the first joint is 10 N m, sigma0 5000 N m/rad
  live.push = {0, 5, 0, 1};
  run(1);
  EXPECT_GT(moved(0), 5.0 / 5000);  // LuGre yields a little even below Fc
  EXPECT_LT(moved(0), 4 * 5.0 / 5000);
  live.push.torque = 20;
  run(1);
  EXPECT_GT(moved(0), 0.1);
  for (int j = 1; j < 6; ++j) EXPECT_NEAR(moved(j), 0, 0.02) << j;
}

TEST_F(LiveArmTest, ASlidersParameterActsAtOnce) {
  live.push = {0, 8, 0, 1};
  run(1);
  EXPECT_LT(moved(0), 0.02);
  const double t = live.time();
  live.set_parameter(parameter(0, "Fc"), 1);
  live.set_parameter(parameter(0, "Fs"), 1);
  EXPECT_EQ(live.time(), t);
  run(1);
  EXPECT_GT(moved(0), 0.1);
}

TEST_F(LiveArmTest, ParametersStayInTheirBounds) {
  const int index = parameter(0, "Fc");
  live.set_parameter(index, -7);
  EXPECT_EQ(live.friction().theta[static_cast<std::size_t>(index)],
            live.friction().model.parameters()[static_cast<std::size_t>(index)].info.lower);
}

TEST_F(LiveArmTest, SwingsGentlyWithinItsLimits) {
  live.swings = true;
  run(0.1);
  for (int j = 0; j < 6; ++j) EXPECT_NEAR(moved(j), 0, 0.02) << j;  // no jump at the start
  run(12);
  const auto& joints = problem.robot.joints;
  for (std::size_t j = 0; j < joints.size(); ++j) {
    double low = 0, high = 0;
    for (const Moment& moment : live.history()) {
      const double q = moment.q[j] - problem.scene.excitation.centre[j];
      low = std::min(low, q);
      high = std::max(high, q);
      EXPECT_LT(std::abs(moment.v[j]), 0.5 * joints[j].velocity) << joints[j].name;
      EXPECT_LT(std::abs(moment.tau[j]), joints[j].effort) << joints[j].name;
    }
    EXPECT_GT(high, 0.1) << joints[j].name;
    EXPECT_LT(low, -0.1) << joints[j].name;
    EXPECT_LT(std::max(high, -low), 0.5 * problem.scene.excitation.half_range[j]) << joints[j].name;
  }
}

TEST_F(LiveArmTest, TheSwingIsTheSameEachTime) {
  live.swings = true;
  run(2);
  const sim::State first = live.state();
  live.reset();
  run(2);
  EXPECT_EQ(live.state().q, first.q);
}

TEST_F(LiveArmTest, APushTakesOverFromTheSwing) {
  live.swings = true;
  run(4.6);
  live.swings = false;
  live.push = {0, 0, 0, 1};
  run(3);
  for (int j = 1; j < 6; ++j) EXPECT_NEAR(moved(j), 0, 0.05) << j;  // as near as friction lets it
  const double left = moved(0);
  EXPECT_GT(std::abs(left), 0.02);  // nothing moves the free joint back
  run(1);
  EXPECT_NEAR(moved(0), left, 1e-3);
}

TEST_F(LiveArmTest, APushedJointGlidesBackIntoTheSwing) {
  live.push = {0, 20, 0, 1};
  run(2);
  ASSERT_GT(moved(0), 0.4);
  live.swings = true;
  const double begin = live.time();
  run(4);
  const auto& joint = problem.robot.joints[0];
  for (const Moment& moment : live.history())
    ASSERT_TRUE(moment.t <= begin || std::abs(moment.tau[0]) < joint.effort) << moment.t;
  EXPECT_LT(std::abs(moved(0)), 0.4);
}

TEST_F(LiveArmTest, HistoryHoldsTheLastSeconds) {
  live.push = {5, 0, 3, 2};
  run(1);
  EXPECT_NEAR(live.history().back().t - live.history().front().t, 1, 0.01);
  run(LiveArm::kHistory);
  EXPECT_LE(live.history().back().t - live.history().front().t, LiveArm::kHistory + 0.01);
  live.reset();
  EXPECT_EQ(live.time(), 0);
  EXPECT_TRUE(live.history().empty());
  EXPECT_NEAR(moved(5), 0, 0);
}

TEST_F(LiveArmTest, ASlowComputerLosesTimeNotSteps) {
  live.advance(0.01);
  EXPECT_NEAR(live.time(), 0.008, 1e-9);  // two samples of 4 ms; the rest waits
  live.advance(0.002);
  EXPECT_NEAR(live.time(), 0.012, 1e-9);
  live.advance(5);
  EXPECT_LE(live.time(), 0.012 + LiveArm::kMostPerCall + 1e-9);
}

}  // namespace
}  // namespace fricid::viewer
