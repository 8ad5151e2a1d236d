#include "fricid/viewer/live_arm.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "fricid/sim/simulate.hpp"

namespace fricid::viewer {
namespace {

class LiveArmTest : public ::testing::Test {
 protected:
  data::Experiment experiment =
      data::load_experiment(std::string(FRICID_SOURCE_DIR) + "/scenes/kr6_lugre.toml");
  sim::MujocoArm arm = sim::make_arm(experiment);
  LiveArm live{arm, experiment, *experiment.friction};

  double moved(int joint) const {
    return live.state().q[static_cast<std::size_t>(joint)] -
           experiment.excitation.centre[static_cast<std::size_t>(joint)];
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
