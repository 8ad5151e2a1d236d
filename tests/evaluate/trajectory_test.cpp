#include "fricid/evaluate/trajectory.hpp"

#include <gtest/gtest.h>

#include <limits>

namespace fricid::evaluate {
namespace {

Trajectory blank(int T) {
  Trajectory trajectory;
  trajectory.data.rate_hz = 250;
  trajectory.data.t = Eigen::VectorXd::Zero(T);
  return trajectory;
}

void expect_start(const Start& start, int trajectory, int begin, int steps) {
  EXPECT_EQ(start.trajectory, trajectory);
  EXPECT_EQ(start.begin, begin);
  EXPECT_EQ(start.steps, steps);
}

TEST(HorizonSteps, CountsSamplesAfterTheStart) {
  EXPECT_EQ(horizon_steps(0.1, 0.004, 1000), 25);
  EXPECT_EQ(horizon_steps(0, 0.004, 1000), 999);
  EXPECT_EQ(horizon_steps(4, 0.004, 1000), 999);  // a log of 4 s ends a sample before
  EXPECT_EQ(horizon_steps(5, 0.004, 1000), 1250);
}

TEST(PlanStarts, FullLengthFromTheFirstSampleAndLaterStartsToTheEnd) {
  const std::vector<Trajectory> trajectories{blank(1001), blank(501)};
  const std::vector<double> horizons{0.1, 1, 0};
  const std::vector<Start> plan = plan_starts(trajectories, horizons, 3);
  ASSERT_EQ(plan.size(), 8u);
  expect_start(plan[0], 0, 0, 1000);
  expect_start(plan[1], 0, 250, 250);
  expect_start(plan[2], 0, 500, 250);
  expect_start(plan[3], 0, 750, 250);
  expect_start(plan[4], 1, 0, 500);
  expect_start(plan[7], 1, 250, 250);
}

TEST(PlanStarts, ShortRecordingTakesTheHorizonsThatFit) {
  const std::vector<Trajectory> trajectories{blank(101)};
  const std::vector<double> horizons{0.1, 10};
  const std::vector<Start> plan = plan_starts(trajectories, horizons, 1);
  ASSERT_EQ(plan.size(), 2u);
  expect_start(plan[0], 0, 0, 100);
  expect_start(plan[1], 0, 75, 25);
}

TEST(PlanStarts, OnlyFullLengthHasNoLaterStarts) {
  const std::vector<Trajectory> trajectories{blank(101)};
  const std::vector<double> horizons{0};
  EXPECT_EQ(plan_starts(trajectories, horizons, 4).size(), 1u);
}

TEST(HeldTorque, RepeatsTheLastValue) {
  const double gap = std::numeric_limits<double>::quiet_NaN();
  data::Dataset dataset;
  dataset.tau.resize(4, 2);
  dataset.tau << gap, 1, 2, gap, gap, gap, 5, 6;
  RowMatrix expected(4, 2);
  expected << 0, 1, 2, 1, 2, 1, 5, 6;
  EXPECT_EQ(held_torque(dataset), expected);
}

}  // namespace
}  // namespace fricid::evaluate
