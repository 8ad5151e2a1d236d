#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "fricid/base/not_finite.hpp"
#include "fricid/evaluate/evaluate.hpp"

namespace fricid::evaluate {
namespace {

/// A result with one horizon whose rollouts have the given errors, one trajectory each.
ModelResult result(const std::string& name, std::vector<double> q_mse, int seed = 1) {
  ModelResult model;
  model.name = model.label = name;
  model.seed = seed;
  model.is_oracle = name == "oracle";
  model.is_conventional = name == "simple" || name == "lugre";
  int trajectory = 0;
  for (const double value : q_mse) {
    RolloutScore score;
    score.trajectory = trajectory++;
    score.error.add({value, 0, value, 0, {}, {}, {}, {}});
    model.scores.push_back(score);
  }
  return model;
}

Evaluation report_of(std::vector<ModelResult> models, double min_headroom = 10,
                     double halving = kNan) {
  Evaluation report;
  report.horizons_s = {10};
  report.trajectories = {"a", "b", "c"};
  report.models = std::move(models);
  report.halving = {halving};
  summarise(report, min_headroom, {});
  return report;
}

TEST(Summary, HeadroomClosedIsZeroForTheConventionAndOneForPhysics) {
  const Evaluation report =
      report_of({result("oracle", {1e-6, 1e-4}), result("simple", {1e-2, 1e-2}),
                 result("lugre", {1e-3, 1e-3}), result("lvm", {1e-5, 1e-3})});
  EXPECT_NEAR(report.oracle[0], 1e-5, 1e-18);
  EXPECT_NEAR(report.best_conventional[0], 1e-3, 1e-16);
  EXPECT_NEAR(report.headroom[0], 100, 1e-10);
  EXPECT_NEAR(report.summary[0].headroom_closed[0], 1, 1e-15);
  EXPECT_NEAR(report.summary[1].headroom_closed[0], -0.5, 1e-12);
  EXPECT_EQ(report.summary[2].headroom_closed[0], 0);
  EXPECT_NEAR(report.summary[3].headroom_closed[0], 0.5, 1e-12);
  EXPECT_NEAR(report.summary[3].ratio_to_oracle[0], 10, 1e-12);
}

TEST(Summary, AModelInDoubtIsNoConventionToBeat) {
  ModelResult doubtful = result("lugre", {1e-4});
  doubtful.doubts = {"fit: j1: R2 -249 on its own training torque"};
  const Evaluation report =
      report_of({result("oracle", {1e-6}), result("simple", {1e-2}), doubtful});
  EXPECT_DOUBLE_EQ(report.best_conventional[0], 1e-2);
  EXPECT_FALSE(report.trusted());
  EXPECT_EQ(report.summary[2].doubts, doubtful.doubts);
  EXPECT_NE(to_markdown(report).find("lugre (not to be trusted)"), std::string::npos);
  EXPECT_TRUE(report_of({result("simple", {1e-2})}).trusted());
}

TEST(Summary, AnUnconventionalModelIsNoConventionToBeat) {
  const Evaluation report =
      report_of({result("oracle", {1e-6}), result("simple", {1e-2}), result("lvm", {1e-5})});
  EXPECT_DOUBLE_EQ(report.best_conventional[0], 1e-2);
}

TEST(Summary, PoolsSeeds) {
  const Evaluation report =
      report_of({result("lvm", {1, 100}, 1), result("lvm", {10, 10}, 2), result("lvm", {1}, 3)});
  ASSERT_EQ(report.summary.size(), 1u);
  const Summary& summary = report.summary[0];
  EXPECT_EQ(summary.seeds, 3);
  EXPECT_EQ(summary.rollouts, 5);
  EXPECT_NEAR(summary.q_mse_geometric_mean[0], std::pow(10, 4.0 / 5), 1e-12);
  EXPECT_DOUBLE_EQ(summary.q_mse_mean[0], 122.0 / 5);
  EXPECT_DOUBLE_EQ(summary.q_mse_median[0], 10);
}

// Seeds' logarithms (base 10) 1, 1, 0: mean 2/3, standard error 1/3, t(0.95, 2) = 2.92.
TEST(Summary, IntervalOverSeedsByHand) {
  const Evaluation report =
      report_of({result("lvm", {1, 100}, 1), result("lvm", {10, 10}, 2), result("lvm", {1}, 3)});
  const Summary& summary = report.summary[0];
  EXPECT_EQ(summary.interval_over, "seeds");
  EXPECT_NEAR(std::log10(summary.interval_90[0].low), 2.0 / 3 - 2.91999 / 3, 1e-5);
  EXPECT_NEAR(std::log10(summary.interval_90[0].high), 2.0 / 3 + 2.91999 / 3, 1e-5);
}

TEST(Summary, OneSeedHasAnIntervalOverTrajectories) {
  const Evaluation report = report_of({result("lvm", {1, 100})});
  EXPECT_EQ(report.summary[0].interval_over, "trajectories");
  EXPECT_NEAR(std::log10(report.summary[0].interval_90[0].high), 1 + 6.313752, 1e-5);
  EXPECT_EQ(report_of({result("lvm", {1})}).summary[0].interval_over, "none");
}

TEST(Verdict, EnoughHeadroomIsMeaningful) {
  const Evaluation report = report_of({result("oracle", {1e-6}), result("simple", {1.1e-5})}, 10);
  EXPECT_TRUE(report.meaningful());
  EXPECT_EQ(report.meaningless[0], "");
}

TEST(Verdict, AnOracleNearTheModelsMakesAHorizonMeaningless) {
  const Evaluation report = report_of({result("oracle", {1e-6}), result("simple", {9e-6})}, 10);
  EXPECT_FALSE(report.meaningful());
  EXPECT_THAT(report.meaningless[0], ::testing::HasSubstr("10 s"));
  EXPECT_THAT(report.meaningless[0], ::testing::HasSubstr("(oracle)"));
}

TEST(Verdict, AStepThatMattersMakesAHorizonMeaningless) {
  const Evaluation report =
      report_of({result("oracle", {1e-8}), result("simple", {9e-6})}, 10, 1e-6);
  EXPECT_DOUBLE_EQ(report.floor[0], 1e-6);
  EXPECT_NEAR(report.headroom[0], 900, 1e-9);
  EXPECT_THAT(report.meaningless[0], ::testing::HasSubstr("halving the truth's physics step"));
}

TEST(Verdict, WithoutAnOracleThereIsNone) {
  const Evaluation report = report_of({result("simple", {9e-6})}, 10);
  EXPECT_TRUE(report.meaningful());
  EXPECT_TRUE(std::isnan(report.summary[0].headroom_closed[0]));
  EXPECT_TRUE(std::isnan(report.summary[0].ratio_to_oracle[0]));
}

}  // namespace
}  // namespace fricid::evaluate
