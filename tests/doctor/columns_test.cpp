// Columns that are not what they are taken for: of other motors, other directions, of nothing.
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <limits>
#include <vector>

#include "doctor/clean_logs.hpp"
#include "fricid/system/transmission.hpp"

namespace fricid::doctor {
namespace {

using data::Dataset;
using data::RowMatrix;

// The torques of two coupled motors beside the positions of their joints.
TEST(Doctor, TorquesOfCoupledMotorsAreNoTorquesOfJoints) {
  auto [log, robot] = clean_logs()[0];
  robot.couplings = {{.joint = 2, .motor = 1, .factor = -1}};
  EXPECT_TRUE(of_kind(diagnose(log, &robot), "coupled").empty());
  log.tau = Transmission(robot).torque_to_motors(log.tau);
  const std::vector<Finding> findings = diagnose(log, &robot);
  const auto coupled = of_kind(findings, "coupled");
  ASSERT_EQ(coupled.size(), 1u) << text_of(findings, log);
  EXPECT_EQ(coupled[0].signal, "tau");
  EXPECT_NE(coupled[0].unit.find("columns of motors"), std::string::npos) << coupled[0].unit;
}

// Positions and torques of motors whose coupling neither the robot's file nor the contract has.
TEST(Doctor, ColumnsOfMotorsThatNoFileCouplesAreFound) {
  for (const double factor : {-1.0, 0.5}) {
    auto [log, robot] = clean_logs()[0];
    dynamics::RobotModel coupled = robot;
    coupled.couplings = {{.joint = 2, .motor = 1, .factor = factor}};
    log = Transmission(coupled).to_motors(log);
    const std::vector<Finding> findings = diagnose(log, &robot);
    const auto found = of_kind(findings, "coupled");
    ASSERT_EQ(found.size(), 1u) << text_of(findings, log);
    EXPECT_THAT(found[0].unit, testing::HasSubstr(fmt::format(
                                   "joint = \"{}\", motor = \"{}\", factor = {:.3g}",
                                   robot.joints[2].name, robot.joints[1].name, factor)));
  }
}

// Each alone makes the others worse.
TEST(Doctor, SeveralAxesThatTurnTheOtherWayAreFoundTogether) {
  for (const std::vector<int>& axes : {std::vector{1, 2}, {0, 1, 2}}) {
    Dataset log = clean_logs()[0].data;
    for (const int j : axes)
      for (RowMatrix* x : {&log.q, &log.v, &log.tau}) x->col(j) *= -1;
    const std::vector<Finding> findings = diagnose(log, &clean_logs()[0].robot);
    std::vector<int> found;
    for (const Finding& f : of_kind(findings, "sign")) {
      EXPECT_EQ(f.signal, "q v tau");
      found.push_back(f.joint);
    }
    EXPECT_EQ(found, axes) << text_of(findings, log);
  }
}

// Nothing but that it is missing is said of a column without a value.
TEST(Doctor, AColumnWithoutAValueIsMissingAndNothingElse) {
  Dataset log = clean_logs()[0].data;
  log.tau.col(1).setConstant(std::numeric_limits<double>::quiet_NaN());
  log.temperature = RowMatrix::Constant(log.length(), log.n(), 300);
  log.temperature.col(0).setConstant(std::numeric_limits<double>::quiet_NaN());
  const std::vector<Finding> findings = diagnose(log, nullptr);
  EXPECT_EQ(of_kind(findings, "missing").size(), 1u) << text_of(findings, log);
  EXPECT_TRUE(of_kind(findings, "quantised").empty()) << text_of(findings, log);
  EXPECT_TRUE(of_kind(findings, "temperature_unit").empty()) << text_of(findings, log);
}

// Rows that all columns lost are one finding beside what a column lost alone.
TEST(Doctor, RowsThatAllColumnsLostAreOneFinding) {
  Dataset log = clean_logs()[0].data;
  const double missing = std::numeric_limits<double>::quiet_NaN();
  for (RowMatrix* x : {&log.q, &log.tau}) x->middleRows(700, 20).setConstant(missing);
  const std::vector<Finding> of_all = of_kind(diagnose(log, nullptr), "missing");
  ASSERT_EQ(of_all.size(), 1u);
  EXPECT_EQ(of_all[0].joint, -1);
  EXPECT_EQ(of_all[0].signal, "q, tau");
}

}  // namespace
}  // namespace fricid::doctor
