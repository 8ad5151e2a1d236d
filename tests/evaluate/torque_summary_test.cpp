#include "fricid/evaluate/torque_summary.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "blank_evaluation.hpp"

namespace fricid::evaluate {
namespace {

using ::testing::ElementsAre;

/// A static law and a law with memory, two joints: 20 and 40 %, 10 and 50 % of the torque.
Evaluation two_laws() {
  Evaluation evaluation = blank_evaluation("arm", {1}, {"validation_0"});
  add_model(evaluation, "oracle", true, {1e-9});
  add_model(evaluation, "simple", false, {1e-4});
  add_model(evaluation, "lugre", false, {1e-5});
  evaluation.models[2].friction_states = 2;
  for (const std::size_t m : {1U, 2U}) {
    TorquePrediction& torque = evaluation.models[m].torque.emplace_back();
    torque.percent_of_rms = m == 1 ? std::vector{20.0, 40.0} : std::vector{10.0, 50.0};
    torque.rmse.all = {2, 4};
    torque.rmse.reversal = {4, 4};
    torque.rmse.presliding = {1, std::numeric_limits<double>::quiet_NaN()};
    torque.rmse.sliding = {2, 4};
    torque.one_step = {1, 1};
    torque.drift = {0.3, -0.3};
    torque.drift_error = {0.2, 0.05};
  }
  return evaluation;
}

TEST(TorqueSummary, ModelsWithoutAPredictionAreLeftOut) {
  const std::vector<TorqueSummary> found = torque_summaries(two_laws());
  ASSERT_EQ(found.size(), 2U);
  EXPECT_EQ(found[0].model, "simple");
  EXPECT_TRUE(found[0].is_static_law);
  EXPECT_FALSE(found[1].is_static_law);
}

// The RMSE of a regime over that of the whole recording, times the percentage of the whole.
TEST(TorqueSummary, RegimesAreMeansOverJointsOfTheirPercentages) {
  const TorqueSummary simple = torque_summaries(two_laws()).front();
  EXPECT_DOUBLE_EQ(simple.reversal, (2 * 20 + 1 * 40) / 2.0);
  EXPECT_DOUBLE_EQ(simple.presliding, 10);  // one joint has no such sample
  EXPECT_DOUBLE_EQ(simple.sliding, 30);
  EXPECT_DOUBLE_EQ(simple.one_step, (0.5 * 20 + 0.25 * 40) / 2);
}

TEST(TorqueSummary, ADriftIsThereBeyondThreeStandardErrors) {
  const TorqueSummary simple = torque_summaries(two_laws()).front();
  EXPECT_FALSE(simple.drifts(0));
  EXPECT_TRUE(simple.drifts(1));
}

TEST(TorqueSummary, JointsCloserThanEveryStaticLawAreCounted) {
  const std::vector<TorqueSummary> found = torque_summaries(two_laws());
  EXPECT_THAT(least_percent(found), ElementsAre(10, 40));
  const std::vector<double> least = least_percent(static_laws(found));
  EXPECT_THAT(least, ElementsAre(20, 40));
  EXPECT_EQ(joints_below(found[1], least), 1);
  EXPECT_TRUE(least_percent({}).empty());
}

}  // namespace
}  // namespace fricid::evaluate
