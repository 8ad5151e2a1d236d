// Columns that are not what they are taken for: of other motors, other directions, of nothing.
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <gmock/gmock.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <string>
#include <vector>

#include "doctor/clean_logs.hpp"
#include "fricid/base/rng.hpp"
#include "fricid/dynamics/algorithms.hpp"
#include "fricid/signals/recording.hpp"
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

// A coupled wrist that is declared, and whose file states no armature: the motors turn by other
// angles than the joints.
TEST(Doctor, ACoupledWristWithoutArmaturesIsSound) {
  auto [log, robot] = clean_logs()[0];
  robot.couplings = {{.joint = 5, .motor = 4, .factor = -1}};
  const Transmission motors(robot);
  const signals::Motion joints = signals::make_recording(log, 10).narrow;
  const RowMatrix q = motors.to_motors(joints.q), v = motors.to_motors(joints.v),
                  a = motors.to_motors(joints.a);
  const auto n = static_cast<std::size_t>(robot.n());
  const std::span<const double> pi{robot.pi.data(), static_cast<std::size_t>(robot.pi.size())};
  dynamics::Workspace<double> ws(robot);
  RowMatrix tau(q.rows(), robot.n());
  for (Eigen::Index k = 0; k < q.rows(); ++k)
    dynamics::rnea<double>(robot, ws, pi, {q.row(k).data(), n}, {v.row(k).data(), n},
                           {a.row(k).data(), n}, {tau.row(k).data(), n});
  log.q = joints.q;
  log.v.resize(0, 0);
  log.tau = motors.torque_to_joints(tau + (0.2 * (v.array() / 0.02).tanh()).matrix());
  robot.pi.segment(robot.armature_begin(), robot.n()).setZero();
  const std::vector<Finding> findings = diagnose(log, &robot);
  EXPECT_TRUE(std::ranges::none_of(findings, misleads)) << text_of(findings, log);
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

/// Joints that turn by 1 rad within 8 s and, of two moves, back, with Coulomb friction; torques of
/// the second and third are swapped.
Dataset swapped_log(const dynamics::RobotModel& robot, int moves) {
  constexpr double kSeconds = 8;
  Dataset log = clean_logs()[0].data;
  const int rows = static_cast<int>(moves * kSeconds * log.rate_hz), n = robot.n();
  log.t = Eigen::VectorXd::LinSpaced(rows, 0, (rows - 1) / log.rate_hz);
  log.v.resize(0, 0);
  log.temperature.resize(0, 0);
  log.q.resize(rows, n);
  log.tau.resize(rows, n);
  dynamics::Workspace<double> ws(robot);
  const auto count = static_cast<std::size_t>(n);
  std::vector<double> q(count), v(count), a(count), tau(count);
  Rng rng(1, 0);
  for (int k = 0; k < rows; ++k) {
    for (int j = 0; j < n; ++j) {
      const auto i = static_cast<std::size_t>(j);
      const double w = std::numbers::pi / kSeconds, phase = w * log.t[k];
      q[i] = 0.1 * j - 0.5 * std::cos(phase) * (1 + 0.1 * j);
      v[i] = 0.5 * w * std::sin(phase) * (1 + 0.1 * j);
      a[i] = 0.5 * w * w * std::cos(phase) * (1 + 0.1 * j);
      log.q(k, j) = q[i] + 1e-6 * rng.normal();
    }
    dynamics::rnea<double>(robot, ws, {robot.pi.data(), static_cast<std::size_t>(robot.pi.size())},
                           q, v, a, tau);
    for (int j = 0; j < n; ++j) {
      const auto i = static_cast<std::size_t>(j);
      log.tau(k, j) = tau[i] + (v[i] < 0 ? -5 : 5) + 0.05 * rng.normal();
    }
  }
  log.tau.col(1).swap(log.tau.col(2));
  return log;
}

// In a joint that slides in one direction friction is a constant torque, and many a mistake that
// was not made explains what is left.
TEST(Doctor, OneDirectionSaysNothingOfColumns) {
  const dynamics::RobotModel& robot = clean_logs()[0].robot;
  EXPECT_FALSE(of_kind(diagnose(swapped_log(robot, 2), &robot), "swapped").empty());
  EXPECT_TRUE(of_kind(diagnose(swapped_log(robot, 1), &robot), "swapped").empty());
}

// Nothing but that it is missing is said of a column without a value.
TEST(Doctor, AColumnWithoutAValueIsMissingAndNothingElse) {
  Dataset log = clean_logs()[0].data;
  log.tau.col(1).setConstant(std::numeric_limits<double>::quiet_NaN());
  log.temperature = RowMatrix::Constant(log.length(), log.n(), 300);
  log.temperature.col(0).setConstant(std::numeric_limits<double>::quiet_NaN());
  const std::vector<Finding> findings = diagnose(log, nullptr);
  const std::vector<Finding> missing = of_kind(findings, "missing");
  ASSERT_EQ(missing.size(), 1u) << text_of(findings, log);
  EXPECT_TRUE(is_damage(missing[0]) && misleads(missing[0]));
  EXPECT_TRUE(of_kind(findings, "quantised").empty()) << text_of(findings, log);
  EXPECT_TRUE(of_kind(findings, "temperature_unit").empty()) << text_of(findings, log);
}

// A torque that every tenth sample lacks: near each sample that lacks it a filtered signal
// is made up.
TEST(Doctor, MissingValuesThatLeaveNothingAreDamage) {
  Dataset log = clean_logs()[0].data;
  for (Eigen::Index k = 0; k < log.tau.rows(); k += 10)
    log.tau.row(k).setConstant(std::numeric_limits<double>::quiet_NaN());
  const std::vector<Finding> missing = of_kind(diagnose(log, nullptr), "missing");
  ASSERT_EQ(std::ssize(missing), log.n());
  for (const Finding& f : missing) {
    EXPECT_TRUE(is_damage(f) && misleads(f));
    EXPECT_NE(to_text(f, log).find("nothing is left of the log"), std::string::npos)
        << to_text(f, log);
  }
  EXPECT_FALSE(info_of(FindingKind::kMissing).remedy.empty());
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
  EXPECT_FALSE(is_damage(of_all[0]));  // a fit leaves them out
}

// What is the same in several joints or logs is one line.
TEST(Doctor, EqualFindingsOfJointsAndLogsAreOneLine) {
  std::vector<Dataset> logs(3, clean_logs()[0].data);
  std::vector<std::vector<Finding>> findings(3);
  for (std::size_t i = 0; i < logs.size(); ++i) logs[i].name = "train_" + std::to_string(i);
  const auto finding = [](FindingKind kind, int joint, double size, int other = -1) {
    return Finding{.kind = kind,
                   .signal = "q",
                   .joint = joint,
                   .other = other,
                   .end_s = 9,
                   .size = size,
                   .unit = "rad"};
  };
  for (std::size_t i = 0; i < 2; ++i)
    for (const int j : {0, 2}) findings[i].push_back(finding(FindingKind::kAngleUnit, j, 50 + j));
  findings[2] = {finding(FindingKind::kAngleUnit, 1, 40), finding(FindingKind::kSwapped, 3, 7, 4),
                 finding(FindingKind::kSwapped, 4, 8, 5)};
  const std::vector<std::string>& joints = logs[0].joint_names;
  const std::vector<std::string> lines = to_lines(findings, logs);
  ASSERT_EQ(lines.size(), 4u) << fmt::format("{}", fmt::join(lines, "\n"));
  EXPECT_TRUE(lines[0].starts_with(fmt::format(
      "train_0, train_1: damage: angle_unit: q of {}, {}, 0 to 9 s: 50 to 52 rad (4 times); ",
      joints[0], joints[2])))
      << lines[0];
  EXPECT_TRUE(lines[1].starts_with(
      fmt::format("train_2: damage: angle_unit: q of {}, 0 to 9 s: 40 rad; ", joints[1])))
      << lines[1];
  EXPECT_NE(lines[2].find(joints[3] + " and " + joints[4]), std::string::npos) << lines[2];
}

}  // namespace
}  // namespace fricid::doctor
