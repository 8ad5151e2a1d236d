#include "fricid/evaluate/warnings.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "blank_evaluation.hpp"

namespace fricid::evaluate {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

const std::vector<std::string> kJoints{"a1", "a2"};

data::FitFile good_fit() {
  data::FitFile fit;
  fit.usable = true;
  fit.outcome = data::Outcome::kConverged;
  for (const std::string& joint : kJoints) fit.joints.emplace_back().joint = joint;
  fit.rigid_body.rows = {90, 80};
  fit.rigid_body.rows_total = {100, 100};
  fit.rigid_body.condition = 20;
  return fit;
}

/// What is found in a fit, in order.
std::vector<std::string> found_in(const data::FitFile& fit) {
  std::vector<std::string> found;
  for (const Warning& warning : warnings_of(fit, "LuGre", kJoints)) {
    EXPECT_FALSE(warning.meaning.empty() || warning.remedy.empty()) << warning.found;
    found.push_back(warning.found);
  }
  return found;
}

TEST(Warnings, AGoodFitHasNone) { EXPECT_THAT(found_in(good_fit()), IsEmpty()); }

TEST(Warnings, FaultsNameTheirJoint) {
  data::FitFile fit = good_fit();
  fit.usable = false;
  fit.faults = {{"a2", "stood still", "move it"}, {"", "too short", "record more"}};
  const std::vector<Warning> warnings = warnings_of(fit, "LuGre", kJoints);
  ASSERT_EQ(warnings.size(), 2U);  // the faults say why it is not usable
  EXPECT_EQ(warnings[0].subject, "LuGre, a2");
  EXPECT_EQ(warnings[0].remedy, "move it");
  EXPECT_EQ(warnings[1].subject, "LuGre");
}

TEST(Warnings, AFitThatFailedSaysHow) {
  data::FitFile fit = good_fit();
  fit.usable = false;
  fit.outcome = data::Outcome::kFailed;
  fit.message = "no finite value";
  EXPECT_THAT(found_in(fit), ElementsAre("the fit ended as \"failed\": no finite value"));
  fit.usable = true;
  fit.outcome = data::Outcome::kIterationLimit;
  EXPECT_THAT(found_in(fit), ElementsAre("the fit stopped at its limit of iterations"));
}

TEST(Warnings, NominalValuesThatWereAskedForAreNoSurprise) {
  data::FitFile fit = good_fit();
  fit.rigid_body.prior = "asked for";
  EXPECT_THAT(found_in(fit), IsEmpty());
  fit.rigid_body.prior = "a1 hardly moved";
  EXPECT_THAT(found_in(fit), ElementsAre(HasSubstr("as a prior: a1 hardly moved")));
}

TEST(Warnings, AMendedInertiaIsSaid) {
  data::FitFile fit = good_fit();
  fit.rigid_body.mended_links = {"arm", "wrist"};
  EXPECT_THAT(found_in(fit),
              ElementsAre(HasSubstr("inertia of arm and wrist in the robot's file")));
}

TEST(Warnings, AHeldArmatureIsSaid) {
  data::FitFile fit = good_fit();
  fit.rigid_body.held_armatures = {{"a2", -0.2, 0.01, 0.5}};
  EXPECT_THAT(found_in(fit), ElementsAre("its torque shows no inertia (-0.2 +- 0.01 kg m^2): its "
                                         "armature is held at 0.5"));
}

TEST(Warnings, RemarksOnParametersAreSaid) {
  data::FitFile fit = good_fit();
  fit.remarks = {{"sigma0 is a guess", "so are reversals", "log faster"}};
  EXPECT_THAT(found_in(fit), ElementsAre("sigma0 is a guess"));
}

TEST(Warnings, BoundsAndSeveralMinimaAreListedByJoint) {
  data::FitFile fit = good_fit();
  fit.joints[0].at_bound = {"Fc", "vs"};
  fit.joints[1].at_bound = {"Fv"};
  fit.joints[0].start_rms = {1, 1.04};
  fit.joints[1].start_rms = {2, 1, 1.06};
  EXPECT_THAT(
      found_in(fit),
      ElementsAre("on a bound: Fc, vs of a1 and Fv of a2",
                  "searches from several starts ended at different errors: a2 (1 to 2 N m)"));
}

TEST(Warnings, FrictionUnderLoadThatTheLawLacksIsNamedByJoint) {
  data::FitFile fit = good_fit();
  EXPECT_FALSE(growth_of(fit, "LuGre", kJoints));
  data::FittedLoadGrowth& growth = fit.rigid_body.load_growth.emplace();
  growth.coefficient = Eigen::Vector2d(0.06, 0.05);
  growth.standard_error = Eigen::Vector2d(0.001, 0.02);
  EXPECT_THAT(found_in(fit), ElementsAre("friction grows with the load: 0.06 +- 0.001 of the "
                                         "motor's torque of a1"));
  growth.side = data::GearSide::kLink;
  const std::optional<Warning> of_link = growth_of(fit, "LuGre", kJoints);
  ASSERT_TRUE(of_link);
  EXPECT_THAT(of_link->found, HasSubstr("of the link's torque of a1"));
  EXPECT_THAT(of_link->remedy, HasSubstr("gear_load"));
  growth.modelled = true;
  EXPECT_FALSE(growth_of(fit, "LuGre", kJoints));
}

TEST(Warnings, APoorRegressionIsOne) {
  data::FitFile fit = good_fit();
  fit.rigid_body.condition = 101;
  fit.rigid_body.rows = {49, 50};
  EXPECT_THAT(found_in(fit), ElementsAre("condition of the regression 101",
                                         "few rows entered the regression: 49 % of a1"));
}

TEST(Warnings, TrainingThatWentAstray) {
  data::FitFile fit = good_fit();
  fit.torque.emplace().skipped = 7;
  fit.multi_step.emplace().chosen = 3;
  fit.multi_step->returns = 2;
  EXPECT_THAT(found_in(fit),
              ElementsAre("7 training steps were skipped",
                          "training diverged and returned to its best point 2 times"));
  fit = good_fit();
  fit.multi_step.emplace().chosen = 0;
  EXPECT_THAT(found_in(fit), ElementsAre("training did not improve on its start"));
  fit = good_fit();
  fit.em.emplace().chosen = -1;
  fit.em->warnings = {"few particles"};
  EXPECT_THAT(found_in(fit), ElementsAre("few particles", "training did not improve on its start"));
  fit.em->chosen = 0;  // the first iteration
  EXPECT_THAT(found_in(fit), ElementsAre("few particles"));
}

TEST(Warnings, OfAnEvaluation) {
  Evaluation evaluation = blank_evaluation("arm", {1, 10}, {"validation_0"});
  add_model(evaluation, "simple", false, {1e-4, 1e-2});
  EXPECT_THAT(warnings_of(evaluation), IsEmpty());
  evaluation.summary[0].doubts = {"a1 stood still"};
  evaluation.summary[0].diverged = 1;
  evaluation.summary[0].rollouts = 4;
  evaluation.meaningless[1] = "headroom 2 below 10";
  evaluation.unexplained = {{"validation_0", "a2", "", false, 3, 4.5, 0.3, 20, 0.5}};
  EXPECT_FALSE(evaluation.trusted());
  const std::vector<Warning> warnings = warnings_of(evaluation);
  ASSERT_EQ(warnings.size(), 4U);
  EXPECT_EQ(warnings[0].found, "a1 stood still");
  EXPECT_EQ(warnings[1].found, "1 of 4 rollouts diverged");
  EXPECT_EQ(warnings[2].subject, "validation_0, a2");
  EXPECT_EQ(warnings[2].found,
            "from 3 to 4.5 s 20 N m of its torque are unexplained, 40 times the residual on the "
            "training data (R2 0.3 of the whole recording)");
  EXPECT_EQ(warnings[3].subject, "horizon 10 s");
  EXPECT_EQ(warnings[3].found, "headroom 2 below 10");
}

TEST(Warnings, OfARecordingThatDiffersFromTheTrainingData) {
  Evaluation evaluation = blank_evaluation("arm", {1}, {"validation_0"});
  add_model(evaluation, "simple", false, {1e-4});
  evaluation.unexplained.push_back(
      {.recording = "validation_0", .joint = "", .difference = "the load on link_6 changes"});
  EXPECT_FALSE(evaluation.trusted());
  const std::vector<Warning> warnings = warnings_of(evaluation);
  ASSERT_EQ(warnings.size(), 1U);
  EXPECT_EQ(warnings[0].subject, "validation_0");
  EXPECT_EQ(warnings[0].found, "the load on link_6 changes");
}

TEST(Warnings, AnExcitationThatBreaksALimitNamesItsRecording) {
  EXPECT_EQ(infeasible_excitation("train_0").subject, "train_0");
}

}  // namespace
}  // namespace fricid::evaluate
