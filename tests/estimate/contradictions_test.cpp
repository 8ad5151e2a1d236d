// Logs whose torque contradicts the robot, the other joints or each other: named with what explains
// them.
#include <gmock/gmock.h>

#include <cmath>

#include "fit_of_logs.hpp"
#include "fricid/system/transmission.hpp"

namespace fricid::estimate {
namespace {

using testing::HasSubstr;

TEST(Contradictions, ATorqueThatContradictsTheOtherJointsIsNamedWithItsFactor) {
  const Arm arm = coulomb_arm(5e-3);
  std::vector<data::Dataset> logs;
  for (const std::uint64_t seed : {1, 2, 3}) {
    LogOptions options;
    options.torque_noise = 0.1;
    options.peak_speed = 3;
    options.seed = seed;
    logs.push_back(make_log(arm, options));
  }
  const FitReport right = fit(arm.robot, logs);
  EXPECT_TRUE(right.usable()) << text_of(right.faults);
  for (data::Dataset& log : logs) log.tau.col(1) *= 0.6;
  const FitReport report = fit(arm.robot, logs);
  EXPECT_FALSE(report.usable());
  ASSERT_EQ(report.faults.size(), 1u) << text_of(report.faults);
  EXPECT_EQ(report.faults[0].joint, arm.robot.joints[1].name);
  EXPECT_THAT(report.faults[0].found, HasSubstr("its torque is 0.6"));
  EXPECT_THAT(report.faults[0].remedy, HasSubstr("1.6"));
}

TEST(Contradictions, ASpringThatTheFileLacksIsNamed) {
  const Arm arm = lugre_arm();
  data::Dataset log = noisy_log(arm);
  log.tau.col(1) += 60 * log.q.col(1);
  const FitReport report = fit(arm.robot, {log});
  EXPECT_FALSE(report.usable());
  EXPECT_THAT(text_of(report.faults),
              HasSubstr(arm.robot.joints[1].name + ": its torque goes with its own angle"));
  EXPECT_THAT(text_of(report.faults), HasSubstr("[[robot.torque]]"));
  // stated, it is found and no fault
  dynamics::RobotModel with_spring = arm.robot;
  dynamics::add_linear_torque(
      with_spring,
      {.name = "spring", .joint = 1, .shape = dynamics::LinearTorque::Shape::kLinear, .k = 1});
  const FitReport right = fit(with_spring, {log});
  EXPECT_TRUE(right.usable()) << text_of(right.faults);
  EXPECT_NEAR(right.rigid_body.pi[with_spring.linear_begin()], 60, 1);
}

// As of a palletiser, whose forearm a parallel linkage holds: gravity then goes with the angle of
// the motor alone, as the torque of a spring does.
TEST(Contradictions, ColumnsOfCoupledMotorsAreNamedBeforeASpring) {
  const dynamics::RobotModel apart = small_arm();
  dynamics::RobotModel coupled = apart;
  coupled.couplings = {{.joint = 2, .motor = 1, .factor = -1}};
  const Transmission motors(coupled);
  data::Dataset log = make_log(coulomb_arm(), {});
  const signals::Motion joints = signals::make_recording(log, 10).narrow;
  const RowMatrix q = motors.to_motors(joints.q), v = motors.to_motors(joints.v),
                  a = motors.to_motors(joints.a);
  dynamics::Workspace<double> ws(coupled);
  const auto row = [](const RowMatrix& x, Eigen::Index k) {
    return std::span<const double>(x.row(k).data(), static_cast<std::size_t>(x.cols()));
  };
  for (Eigen::Index k = 0; k < q.rows(); ++k)
    dynamics::rnea<double>(coupled, ws, row(coupled.pi.transpose(), 0), row(q, k), row(v, k),
                           row(a, k), {log.tau.row(k).data(), 3});
  log.q = q;
  log.tau.array() += 2 * (v.array() / 0.02).tanh() + v.array();
  const FitReport report = fit(apart, {log});
  EXPECT_FALSE(report.usable());
  const std::string said = text_of(report.faults);
  EXPECT_THAT(said, HasSubstr("j3: "));
  EXPECT_THAT(said, HasSubstr("[[coupling]] joint = \"j3\", motor = \"j2\", factor = -1"));
}

TEST(Contradictions, ASpringOfASlidingJointIsLinear) {
  Arm arm = coulomb_arm(5e-3);
  arm.robot.joints[0].type = dynamics::JointType::kPrismatic;
  data::Dataset log = make_log(arm, {.torque_noise = 0.2});
  log.tau.col(0) += 200 * log.q.col(0);
  const std::string said = text_of(fit(arm.robot, {log}).faults);
  EXPECT_THAT(said, HasSubstr("j1: its force goes with its own position"));
  EXPECT_THAT(said, HasSubstr("terms = [\"q\"]"));
}

/// Logs of the same motion as seed 1 and 2 of an arm and of another.
std::vector<data::Dataset> logs_of(const Arm& arm, const Arm& other) {
  LogOptions options;
  options.torque_noise = 0.1;
  options.seconds = 24;
  std::vector<data::Dataset> logs{make_log(arm, options)};
  options.seed = 2;
  logs.push_back(make_log(other, options));
  return logs;
}

// One joint at a time: each log knows another joint's friction.
TEST(Contradictions, LogsOfOneJointEachDoNotContradictEachOther) {
  const Arm arm = coulomb_arm(5e-3);
  std::vector<data::Dataset> logs;
  for (int moving = 0; moving < arm.robot.n(); ++moving) {
    LogOptions options;
    options.torque_noise = 0.1;
    options.seed = static_cast<std::uint64_t>(moving + 1);
    options.moving = moving;
    logs.push_back(make_log(arm, options));
  }
  EXPECT_THAT(text_of(fit(arm.robot, logs).faults), testing::Not(HasSubstr("contradict")));
}

TEST(Contradictions, LogsOfAnotherLoadContradictEachOther) {
  const Arm arm = coulomb_arm(5e-3);
  Arm loaded = arm;
  dynamics::add_payload(loaded.robot, {.name = "", .link = arm.robot.n() - 1}, 3, {0.1, 0, 0.1},
                        Eigen::Matrix3d::Identity() * 0.01);
  EXPECT_TRUE(fit(arm.robot, logs_of(arm, arm)).usable());
  const FitReport report = fit(arm.robot, logs_of(arm, loaded));
  EXPECT_FALSE(report.usable());
  EXPECT_THAT(text_of(report.faults), HasSubstr("the logs contradict each other: "));
  EXPECT_THAT(text_of(report.faults), HasSubstr("another load"));
}

// Friction may differ where temperatures say why.
TEST(Contradictions, LogsOfOtherFrictionContradictEachOtherWithoutTemperatures) {
  const Arm cold = coulomb_arm(5e-3);
  Arm warm = cold;
  for (double& value : warm.friction.theta) value *= 0.6;
  for (int j = 0; j < cold.robot.n(); ++j) {
    const auto v0 = static_cast<std::size_t>(
        friction::find_parameter(cold.friction.model, j, friction::Role::kSmoothingSpeed));
    warm.friction.theta[v0] = cold.friction.theta[v0];
  }
  std::vector<data::Dataset> logs = logs_of(cold, warm);
  const FitReport report = fit(cold.robot, logs);
  EXPECT_FALSE(report.usable());
  EXPECT_THAT(text_of(report.faults), testing::ContainsRegex("contradict each other: .*friction"));
  EXPECT_THAT(text_of(report.faults), HasSubstr("log the temperature"));
  for (std::size_t i = 0; i < 2; ++i)
    logs[i].temperature.setConstant(logs[i].length(), cold.robot.n(), i == 0 ? 293 : 313);
  EXPECT_THAT(text_of(fit(cold.robot, logs).faults), HasSubstr("modifiers = [\"temperature\"]"));
  ModelOptions with_temperature = model_of_one_start("coulomb_viscous");
  with_temperature.modifiers = {"temperature"};
  const FitReport of_temperature =
      fit_conventional(prepare(cold.robot, {}, logs, 2), with_temperature, 1, 2);
  EXPECT_THAT(text_of(of_temperature.faults), testing::Not(HasSubstr("contradict")));
  // Coulomb friction at the mean temperature of the logs: half way between 4 and 2.4 N m
  EXPECT_NEAR(of_temperature.joints[0].theta[0], std::sqrt(4 * 2.4), 0.1);
}

}  // namespace
}  // namespace fricid::estimate
