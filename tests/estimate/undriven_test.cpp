// Time in which the motors do not drive the arm is named; time in which they seem not to, is not.
#include <gmock/gmock.h>

#include <array>
#include <cmath>
#include <numbers>

#include "fit_of_logs.hpp"

namespace fricid::estimate {
namespace {

using testing::HasSubstr;

// The arm slows down and stands for two seconds, held by its motors or by brakes.
TEST(Undriven, TimeInWhichBrakesHoldTheArmIsNamed) {
  const Arm arm = lugre_arm();
  data::Dataset log = noisy_log(arm);
  const int T = log.length(), stop = T / 2, slows = 50, rests = 500;
  const dynamics::RobotModel& robot = arm.robot;
  data::Dataset held = log;
  held.q.conservativeResize(stop + slows + rests, Eigen::NoChange);
  held.tau.conservativeResize(stop + slows + rests, Eigen::NoChange);
  held.t =
      Eigen::VectorXd::LinSpaced(stop + slows + rests, 0, (stop + slows + rests - 1) / log.rate_hz);
  const Eigen::RowVectorXd step = log.q.row(stop) - log.q.row(stop - 1);
  for (int k = stop; k < held.length(); ++k)
    held.q.row(k) =
        held.q.row(k - 1) + step * std::max(0.0, 1 - static_cast<double>(k - stop) / slows);
  dynamics::Workspace<double> ws(robot);
  const auto n = static_cast<std::size_t>(robot.n());
  const std::vector<double> zero(n, 0.0);
  for (int k = stop; k < held.length(); ++k) {
    std::vector<double> gravity(n);
    dynamics::rnea<double>(robot, ws, {robot.pi.data(), static_cast<std::size_t>(robot.pi.size())},
                           {held.q.row(k).data(), n}, zero, zero, gravity);
    for (std::size_t j = 0; j < n; ++j) held.tau(k, static_cast<Eigen::Index>(j)) = gravity[j];
  }
  held.name = "held";
  EXPECT_TRUE(fit(robot, {log, held}).usable()) << text_of(fit(robot, {log, held}).faults);

  held.tau.bottomRows(rests).setZero();
  const FitReport report = fit(robot, {log, held});
  EXPECT_FALSE(report.usable());
  EXPECT_THAT(text_of(report.faults),
              HasSubstr("the arm stands and the torque is not what holds "));
  EXPECT_THAT(text_of(report.faults), HasSubstr(" s of held"));
  EXPECT_THAT(text_of(report.faults),
              testing::ContainsRegex("train = ..LOG.:[0-9.]*..] in"));  // nothing comes after

  // the log goes on and stands once more; it was cut from a file at its tenth second
  const data::Dataset once = held;
  const int length = once.length();
  held.q.resize(2 * length, once.n());
  held.tau.resize(2 * length, once.n());
  held.q << once.q, once.q;
  held.tau << once.tau, once.tau;
  held.t = Eigen::VectorXd::LinSpaced(2 * length, 10, 10 + (2 * length - 1) / log.rate_hz);
  EXPECT_THAT(text_of(fit(robot, {log, held}).faults),
              testing::ContainsRegex("train = ..LOG.10:[0-9.]*.., .LOG.[0-9.]*:[0-9.]*..] in"));
}

/// A log of an arm with Coulomb and viscous friction that goes from one of three poses to the next
/// and rests there, held by its motors.
data::Dataset pick_and_place(const dynamics::RobotModel& robot, std::uint64_t seed) {
  constexpr double kRate = 250, kStroke = 1.2, kPause = 0.6, kRamp = 0.2;  // [Hz], [s], [s], [1]
  constexpr int kStrokes = 12, kSamples = static_cast<int>(kStrokes * (kStroke + kPause) * kRate);
  Rng rng(seed, 0);
  std::array<Eigen::RowVector3d, 3> poses;
  for (Eigen::RowVector3d& pose : poses)
    for (double& q : pose) q = 1.6 * rng.uniform() - 0.8;
  data::Dataset log = make_log({robot, same_law("coulomb_viscous", {4, 2, 0.01}, 3)}, {});
  log.rate_hz = kRate;
  log.t = Eigen::VectorXd::LinSpaced(kSamples, 0, (kSamples - 1) / kRate);
  log.q.resize(kSamples, 3);
  log.tau.resize(kSamples, 3);
  dynamics::Workspace<double> ws(robot);
  Eigen::RowVector3d friction = Eigen::RowVector3d::Zero();
  for (int k = 0; k < kSamples; ++k) {
    const int stroke = static_cast<int>(log.t[k] / (kStroke + kPause));
    // share of the way: speeds up over a fifth of the time, goes on steadily, slows down
    const double s = std::min(1.0, (log.t[k] - stroke * (kStroke + kPause)) / kStroke),
                 left = std::min(s, 1 - s), most = 1 / (1 - kRamp),
                 near = left < kRamp ? left * left / (2 * kRamp) * most : (left - kRamp / 2) * most,
                 speed = most * std::min(1.0, left / kRamp) / kStroke,
                 rise = left < kRamp && s < 1 ? most / kRamp / (kStroke * kStroke) : 0;
    const auto pose = static_cast<std::size_t>(stroke) % 3;
    const Eigen::RowVector3d way = poses[(pose + 1) % 3] - poses[pose],
                             q = poses[pose] + way * (s < 0.5 ? near : 1 - near), v = way * speed,
                             a = way * (s < 0.5 ? rise : -rise);
    if (s < 1) friction = (4 * way.array().sign() + 2 * v.array()).matrix();
    Eigen::RowVector3d tau;
    dynamics::rnea<double>(robot, ws, {robot.pi.data(), static_cast<std::size_t>(robot.pi.size())},
                           {q.data(), 3}, {v.data(), 3}, {a.data(), 3}, {tau.data(), 3});
    log.q.row(k) = q;
    for (int j = 0; j < 3; ++j) log.tau(k, j) = tau[j] + friction[j] + 0.3 * rng.normal();
  }
  return log;
}

// Three poses in turn hardly tell Coulomb friction of a joint from its weight and inertia: the
// regression may find none, or less.
TEST(Undriven, RestsBetweenAFewPosesAreHeldByTheMotors) {
  const dynamics::RobotModel robot = small_arm();
  for (std::uint64_t seed = 1; seed <= 24; ++seed) {
    const std::string said =
        text_of(fit(as_published(robot), {pick_and_place(robot, seed)}).faults);
    EXPECT_EQ(said.find("the arm stands"), std::string::npos) << seed << ": " << said;
  }
}

TEST(Undriven, TimeInWhichTheDrivesAreOffIsNamed) {
  const Arm arm = lugre_arm();
  data::Dataset log = noisy_log(arm);
  log.tau.middleRows(log.length() / 2, 500).setZero();
  const FitReport report = fit(arm.robot, {log});
  EXPECT_FALSE(report.usable());
  EXPECT_THAT(text_of(report.faults), HasSubstr("the arm moves and every torque is zero"));
}

// A flywheel runs out against its friction: the motor gives next to nothing for half a second, and
// the regression explains it.
TEST(Undriven, AJointThatRunsOutIsNot) {
  const dynamics::RobotModel robot = dynamics::parse_urdf(
      "<robot name='wheel'><link name='base'/><link name='rotor'><inertial><mass "
      "value='2'/><inertia "
      "ixx='.3' iyy='.3' izz='.5' ixy='0' ixz='0' iyz='0'/></inertial></link><joint name='x' "
      "type='revolute'><parent link='base'/><child link='rotor'/><axis xyz='0 0 1'/><limit "
      "lower='-30' upper='30' velocity='15' effort='100'/></joint></robot>",
      "wheel");
  constexpr double kFc = 2, kFv = 0.3, kI = 0.5, kRate = 500, kPeriod = 8, kFastest = 6;
  data::Dataset log;
  log.name = "runs_out";
  log.joint_names = {"x"};
  log.rate_hz = kRate;
  log.t = Eigen::VectorXd::LinSpaced(16'000, 0, 15'999 / kRate);
  log.q.resize(log.t.size(), 1);
  log.tau.resize(log.t.size(), 1);
  Rng rng(7, 0);
  double q = 0, v = 0;
  const auto motion = [&](double t) {
    return kFastest * std::sin(2 * std::numbers::pi * t / kPeriod);
  };
  for (int k = 0; k < log.t.size(); ++k) {
    const double phase = std::fmod(log.t[k], kPeriod);
    // speeds up with the sine, then runs out by itself until the sine is slower
    const double friction = v == 0 ? 0 : std::copysign(kFc, v) + kFv * v;
    const bool runs_out = std::abs(std::remainder(phase - 2.3, kPeriod / 2)) < 0.25;
    const double next = motion(log.t[k] + 1 / kRate);
    const double a = runs_out ? -friction / kI : (next - v) * kRate * 0.2;
    log.q(k, 0) = q;
    log.tau(k, 0) = kI * a + friction + 0.01 * rng.normal();
    q += v / kRate + a / (2 * kRate * kRate);
    v += a / kRate;
  }
  const FitReport report = fit(robot, {log});
  EXPECT_TRUE(report.usable()) << text_of(report.faults);
  // pushed on by hand, it would be
  data::Dataset pushed = log;
  pushed.tau.middleRows(9000, 300).setZero();
  EXPECT_THAT(text_of(fit(robot, {pushed}).faults), HasSubstr("every torque is zero"));
}

}  // namespace
}  // namespace fricid::estimate
