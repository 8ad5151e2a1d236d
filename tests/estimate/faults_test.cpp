// Fits that are not to be trusted say so: which joint, why, what to do.
#include <gmock/gmock.h>

#include <cmath>

#include "arm_data.hpp"
#include "fricid/estimate/fit.hpp"

namespace fricid::estimate {
namespace {

using testing::HasSubstr;

data::ModelConfig model(const std::string& name) {
  data::ModelConfig config;
  config.name = name;
  config.starts = 1;
  return config;
}

Arm coulomb_arm() {
  Arm arm{small_arm(), {}};
  arm.friction = same_law("coulomb_viscous", {4, 2, 5e-3}, arm.robot.n());
  return arm;
}

FitReport fit(const dynamics::RobotModel& robot, const std::vector<data::Dataset>& logs,
              const std::string& law = "simple") {
  const data::Problem problem = make_problem(robot);
  return fit_conventional(problem, prepare(problem, logs, 2), model(law), 1, 2);
}

std::string text_of(const std::vector<Fault>& faults) {
  std::string text;
  for (const Fault& f : faults) text += f.joint + ": " + f.found + "; " + f.remedy + "\n";
  return text;
}

TEST(Faults, AJointThatRestsIsNamedWithTheWayToHoldItOut) {
  const Arm arm = coulomb_arm();
  data::Dataset log = make_log(arm, {});
  log.q.col(2).setConstant(0.25);
  const FitReport report = fit(arm.robot, {log});
  EXPECT_FALSE(report.usable());
  const std::string text = text_of(report.faults);
  EXPECT_THAT(text, HasSubstr("j3: moves by 0 rad in all training data"));
  EXPECT_THAT(text, HasSubstr("weld it in the URDF (type=\"fixed\")"));
}

TEST(Faults, TorqueThatNothingExplainsIsNotTrusted) {
  const Arm arm = coulomb_arm();
  data::Dataset log = make_log(arm, {});
  Rng rng(1, 0);
  for (double& value : log.tau.col(1)) value = 20 * rng.normal();
  const FitReport report = fit(arm.robot, {log});
  EXPECT_FALSE(report.usable());
  EXPECT_THAT(text_of(report.faults), HasSubstr("j2: R2 "));
  EXPECT_THAT(report.brief(), HasSubstr("NOT TO BE TRUSTED"));
  EXPECT_THAT(report.brief(), HasSubstr("; j2: R2 "));
  const data::FitFile file = fit_file(report);
  EXPECT_FALSE(file.usable);
  EXPECT_THAT(file.message, HasSubstr("j2: R2 "));
}

TEST(Faults, FrictionAboveEveryTorqueIsNotTrusted) {
  const Arm arm = coulomb_arm();
  const data::Problem problem = make_problem(arm.robot);
  const Prepared prepared = prepare(problem, std::vector{make_log(arm, {})}, 2);
  FitReport report = fit_conventional(problem, prepared, model("dahl"), 1, 2);
  ASSERT_TRUE(report.usable()) << text_of(report.faults);
  report.joints[0].theta[0] = 1e4;
  const std::vector<Fault> faults = faults_of(prepared, report);
  ASSERT_EQ(faults.size(), 1u);
  EXPECT_EQ(faults[0].joint, "j1");
  EXPECT_THAT(faults[0].found, HasSubstr("friction of 1e+04 N m, while its torque ranged over"));
}

}  // namespace
}  // namespace fricid::estimate
