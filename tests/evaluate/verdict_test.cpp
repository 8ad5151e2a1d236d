#include "fricid/evaluate/verdict.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "blank_evaluation.hpp"
#include "fricid/base/not_finite.hpp"

namespace fricid::evaluate {
namespace {

using ::testing::ElementsAre;

/// Errors at 1 s and 10 s: the mean logarithm is least for gms, at 1 s lugre is better.
Evaluation three_models() {
  Evaluation evaluation = blank_evaluation("arm", {1, 10}, {"validation_0"});
  add_model(evaluation, "oracle", true, {1e-9, 1e-9});
  add_model(evaluation, "simple", false, {1e-4, 1e-2});
  add_model(evaluation, "lugre", false, {1e-6, 9e-3});
  add_model(evaluation, "gms", false, {2e-6, 1e-3});
  return evaluation;
}

std::vector<std::string> names_of(const std::vector<const Summary*>& summaries) {
  std::vector<std::string> names;
  for (const Summary* summary : summaries) names.push_back(summary->name);
  return names;
}

TEST(Verdict, TheBestModelHasTheLeastErrorOverall) {
  EXPECT_EQ(best_model(three_models())->name, "gms");
}

TEST(Verdict, NoModelInDoubtIsTheBest) {
  Evaluation evaluation = three_models();
  evaluation.summary[3].doubts = {"its fit failed"};
  EXPECT_EQ(best_model(evaluation)->name, "lugre");
  EXPECT_THAT(names_of(trusted_summaries(evaluation)), ElementsAre("simple", "lugre"));
  for (Summary& summary : evaluation.summary) summary.doubts = {"its fit failed"};
  EXPECT_EQ(best_model(evaluation), nullptr);
}

TEST(Verdict, AnotherModelMayBeBetterAtOneHorizon) {
  Evaluation evaluation = three_models();
  const auto better = [&] {
    return names_of(better_at_a_horizon(evaluation, evaluation.summary[3]));
  };
  EXPECT_THAT(better(), ElementsAre("lugre"));
  evaluation.summary[2].q_mse_geometric_mean[0] = 0.96 * 2e-6;  // not clearly below
  EXPECT_TRUE(better().empty());
  evaluation.summary[1].q_mse_geometric_mean = {1e-6, 1e-6};  // each label once
  evaluation.summary[2].q_mse_geometric_mean = {1e-6, 1e-6};
  evaluation.summary[2].label = evaluation.summary[1].label;
  EXPECT_THAT(better(), ElementsAre("simple"));
}

TEST(Verdict, AModelWithoutALabelIsCalledByItsName) {
  Summary summary;
  summary.name = "lugre";
  EXPECT_EQ(label_of(summary), "lugre");
  summary.label = "LuGre";
  EXPECT_EQ(label_of(summary), "LuGre");
}

TEST(Verdict, TheBestWithABandIsThatOfTheLongestHorizon) {
  Evaluation evaluation = three_models();
  EXPECT_EQ(best_with_band(evaluation), nullptr);
  evaluation.summary[0].band_coverage = {0.9, 0.9};  // the oracle
  evaluation.summary[1].band_coverage = {0.9, 0.9};
  evaluation.summary[2].band_coverage = {0.9, 0.9};
  EXPECT_EQ(best_with_band(evaluation)->name, "lugre");
  evaluation.summary[2].q_mse_geometric_mean.back() = kNan;
  EXPECT_EQ(best_with_band(evaluation)->name, "simple");
}

TEST(Verdict, FailuresAreCounted) {
  Evaluation evaluation = three_models();
  evaluation.summary[0].diverged = 1;  // the oracle was not fitted
  evaluation.summary[1].diverged = 2;
  evaluation.meaningless[1] = "headroom 2";
  data::FitFile good, bad;
  good.usable = true;
  good.outcome = data::Outcome::kIterationLimit;
  good.joints.resize(2);
  good.joints[0].at_bound = {"Fc", "Fv"};
  good.joints[1].at_bound = {"vs"};
  bad.outcome = data::Outcome::kFailed;
  const std::vector<const data::FitFile*> fits{&good, &bad};
  const Failures found = failures_of(evaluation, fits);
  EXPECT_THAT(names_of(found.diverging), ElementsAre("simple"));
  EXPECT_EQ(found.unusable_fits, 1);
  EXPECT_EQ(found.limited_fits, 1);
  EXPECT_EQ(found.at_bound, 3);
  EXPECT_THAT(found.blind_horizons, ElementsAre(10));
}

TEST(Verdict, AJointHasTheRangeOfItsFitsAndTheFirstFault) {
  data::FitFile one, other;
  one.joints.resize(2);
  other.joints.resize(2);
  one.joints[0].r2 = 0.9;
  other.joints[0].r2 = 0.4;
  one.joints[1].r2 = other.joints[1].r2 = 0.8;
  other.faults = {{"a1", "explains little", "move more"}, {"a1", "on its bound", "try another"}};
  const std::vector<std::string> joints{"a1", "a2", "a3"};
  const std::vector<LabelledFit> fits{{"LuGre", &one}, {"GMS", &other}};
  const std::vector<JointVerdict> found = joint_verdicts(joints, fits);
  ASSERT_EQ(found.size(), 2U);  // of a3 no fit says anything
  EXPECT_EQ(found[0].joint, "a1");
  EXPECT_EQ(found[0].least_r2, 0.4);
  EXPECT_EQ(found[0].most_r2, 0.9);
  ASSERT_NE(found[0].fault, nullptr);
  EXPECT_EQ(found[0].fault->found, "explains little");
  EXPECT_EQ(found[0].model, "GMS");
  EXPECT_EQ(found[1].least_r2, found[1].most_r2);
  EXPECT_EQ(found[1].fault, nullptr);
}

TEST(Verdict, AFaultAloneIsAVerdictToo) {
  data::FitFile fit;
  fit.faults = {{"a1", "stood still", "move it"}};
  const std::vector<std::string> joints{"a1"};
  const std::vector<LabelledFit> fits{{"LuGre", &fit}};
  const std::vector<JointVerdict> found = joint_verdicts(joints, fits);
  ASSERT_EQ(found.size(), 1U);
  EXPECT_TRUE(std::isnan(found[0].least_r2) && std::isnan(found[0].most_r2));
}

TEST(Verdict, PhysicsMovesAParameterBeyondThreeStandardErrors) {
  data::FittedBaseParameter parameter;
  parameter.value = 1;
  parameter.standard_error = 0.1;
  parameter.physical = 1.25;
  EXPECT_FALSE(is_moved_by_physics(parameter));
  parameter.physical = 0.65;
  EXPECT_TRUE(is_moved_by_physics(parameter));
  parameter.standard_error = kNan;  // not determined by the data
  EXPECT_FALSE(is_moved_by_physics(parameter));
}

}  // namespace
}  // namespace fricid::evaluate
