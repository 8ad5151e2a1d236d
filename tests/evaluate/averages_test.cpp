#include "fricid/evaluate/averages.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "blank_evaluation.hpp"
#include "fricid/base/not_finite.hpp"

namespace fricid::evaluate {
namespace {

Evaluation two_models() {
  Evaluation evaluation = blank_evaluation("arm", {1, 0}, {"validation_0"});
  add_model(evaluation, "oracle", true, {1e-9, 1e-9});
  add_model(evaluation, "simple", false, {1e-4, 1e-2});
  add_model(evaluation, "lugre", false, {1e-3, kNan});
  return evaluation;
}

TEST(Averages, OverallIsTheLogarithmicMeanOfWhatIsKnown) {
  const Evaluation evaluation = two_models();
  EXPECT_NEAR(overall(evaluation.summary[1]), std::log(1e-3), 1e-12);
  EXPECT_NEAR(overall(evaluation.summary[2]), std::log(1e-3), 1e-12);
  EXPECT_EQ(overall(Summary{}), INFINITY);
}

TEST(Averages, TheOracleWasNotFitted) {
  const Evaluation evaluation = two_models();
  const std::vector<const Summary*> fitted = fitted_summaries(evaluation);
  ASSERT_EQ(fitted.size(), 2U);
  EXPECT_EQ(fitted[0]->name, "simple");
  EXPECT_EQ(fitted[1]->name, "lugre");
}

TEST(Averages, ErrorsOfAllSeedsCountAndMissingOnesDoNot) {
  Evaluation evaluation = two_models();
  for (const double mse : {1.0, 3.0, kNan}) {
    ModelResult& seed = evaluation.models.emplace_back();
    seed.name = "gms";
    seed.scores.emplace_back().error.q_mse = {mse};
  }
  EXPECT_DOUBLE_EQ(mean_error(evaluation, "gms", &HorizonErrors::q_mse, 0), 2);
  EXPECT_TRUE(std::isnan(mean_error(evaluation, "nobody", &HorizonErrors::q_mse, 0)));
}

TEST(Averages, ErrorsOfAJointAreGeometric) {
  Evaluation evaluation = two_models();
  const auto add = [&](double mse) {
    evaluation.models[1].scores.emplace_back().error.q_mse_joint = {{kNan, mse}};
  };
  for (const double mse : {1e-4, 1e-8, kNan}) add(mse);
  const JointErrors found = *joint_errors(evaluation, "simple", 1, 0, 1e-9);
  EXPECT_NEAR(found.typical, 1e-3, 1e-15);
  EXPECT_NEAR(found.smallest, 1e-4, 1e-16);
  EXPECT_NEAR(found.largest, 1e-2, 1e-14);
  add(0);  // below what an encoder resolves
  EXPECT_NEAR(joint_errors(evaluation, "simple", 1, 0, 1e-6)->smallest, 1e-6, 1e-18);
  EXPECT_FALSE(joint_errors(evaluation, "simple", 0, 0, 1e-9));
  EXPECT_FALSE(joint_errors(evaluation, "nobody", 1, 0, 1e-9));
}

TEST(Averages, TorqueIsThatOfAllRecordings) {
  Evaluation evaluation = two_models();
  for (const double percent : {10.0, 30.0})
    evaluation.models[1].torque.emplace_back().percent_of_rms = {percent, 2 * percent};
  EXPECT_EQ(mean_of_torque(evaluation, "simple", &TorquePrediction::percent_of_rms),
            (std::vector<double>{20, 40}));
  EXPECT_NEAR(torque_left(evaluation, "simple"), 0.3, 1e-12);
  EXPECT_TRUE(mean_of_torque(evaluation, "lugre", &TorquePrediction::r2).empty());
  EXPECT_TRUE(std::isnan(torque_left(evaluation, "lugre")));
}

TEST(Averages, SecondsAreMeasuredOrElseStated) {
  Summary summary;
  summary.name = "peer";
  summary.stated_fit_seconds = 7;
  EXPECT_EQ(fit_seconds(summary, {}), 7);
  EXPECT_EQ(fit_seconds(summary, {{"peer", 3}, {"lugre", 1}}), 3);
}

TEST(Averages, OneSecondAndTheLongestHorizonAreQuoted) {
  EXPECT_EQ(quoted_horizons({0.1, 1, 10, 31.4}), (std::vector<std::size_t>{1, 3}));
  EXPECT_EQ(quoted_horizons({0.1, 0.3, 2}), (std::vector<std::size_t>{1, 2}));
  EXPECT_EQ(quoted_horizons({0.1, 5}), (std::vector<std::size_t>{0, 1}));
  EXPECT_EQ(quoted_horizons({0.1, 1}), (std::vector<std::size_t>{1}));
  EXPECT_EQ(quoted_horizons({5}), (std::vector<std::size_t>{0}));
}

}  // namespace
}  // namespace fricid::evaluate
