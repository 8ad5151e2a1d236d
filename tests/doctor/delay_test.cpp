// Torque that is late, beyond the search, of one joint alone, or through a filter.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <numbers>

#include "doctor/clean_logs.hpp"
#include "doctor/injected.hpp"
#include "fricid/doctor/doctor.hpp"
#include "fricid/scene/problem.hpp"
#include "fricid/sim/simulate.hpp"
#include "source_dir.hpp"

namespace fricid::doctor {
namespace {

using data::Dataset;

/// A log at 1 kHz of the arm.
const Log& fast_log() {
  static const Log log = [] {
    scene::Scene e = scene::load_scene(source_dir() / "scenes/kr6_full.toml");
    e.excitation.train = 1;
    e.excitation.repeats = 1;
    e.excitation.validation = 0;
    e.excitation.criterion = sim::Criterion::kNone;
    e.excitation.harmonics = 5;
    e.excitation.base_rad_s = 0.6;
    e.sensors.rate_hz = 1000;
    e.plant.step_s = kSimulatorStep;
    const scene::Problem problem = scene::resolve(std::move(e));
    return Log{sim::simulate(problem, 2).train[0], problem.robot};
  }();
  return log;
}

// Reference: the delay that was put in. Half a sample at 250 Hz is 2 ms.
TEST(Doctor, MeasuresDelaysUpToAFifthOfASecond) {
  const auto& [log, robot] = fast_log();
  EXPECT_TRUE(of_kind(diagnose(log, &robot), "delay").empty());
  for (const int ms : {10, 20, 30, 50, 100, 200}) {
    SCOPED_TRACE(ms);
    Dataset late = log;
    delay_torque(late, ms);
    const std::vector<Finding> found = of_kind(diagnose(late, &robot), "delay");
    ASSERT_EQ(found.size(), 1u) << text_of(diagnose(late, &robot), late);
    EXPECT_NEAR(found[0].size, ms, 2);
  }
}

// A clock shifts all joints alike; friction that lags shifts each by another time.
TEST(Doctor, JointsThatDisagreeHaveNoDelay) {
  const auto& [log, robot] = fast_log();
  Dataset apart = log;
  const std::array<double, 6> ms{0, 4, 8, 14, 20, 26};
  for (int j = 0; j < 6; ++j) {
    Dataset late = log;
    delay_torque(late, ms[static_cast<std::size_t>(j)]);
    apart.tau.col(j) = late.tau.col(j);
  }
  EXPECT_TRUE(of_kind(diagnose(apart, &robot), "delay").empty())
      << text_of(diagnose(apart, &robot), apart);
}

// One drive's torque passes another filter, or another bus.
TEST(Doctor, TheTorqueOfOneJointThatIsLateIsNamed) {
  const auto& [log, robot] = fast_log();
  for (const int joint : {1, 2}) {
    Dataset late = log, apart = log;
    delay_torque(late, 24);
    apart.tau.col(joint) = late.tau.col(joint);
    const std::vector<Finding> findings = diagnose(apart, &robot);
    const std::vector<Finding> found = of_kind(findings, "delay");
    ASSERT_EQ(found.size(), 1u) << text_of(findings, apart);
    EXPECT_EQ(found[0].joint, joint);
    EXPECT_NEAR(found[0].size, 24, 3);
    const Dataset mended = repair(apart, findings, {{FindingKind::kDelay}});
    const Eigen::ArrayXd left = mended.tau.col(joint) - log.tau.col(joint),
                         damage = apart.tau.col(joint) - log.tau.col(joint);
    EXPECT_LT(left.square().mean(), 0.1 * damage.square().mean());
    EXPECT_EQ(mended.tau.col(0), apart.tau.col(0));
  }
}

TEST(Doctor, ADelayBeyondTheSearchIsNotReportedAsMeasured) {
  Dataset late = fast_log().data;
  delay_torque(late, 400);
  const std::vector<Finding> findings = diagnose(late, &fast_log().robot);
  EXPECT_TRUE(of_kind(findings, "delay").empty()) << text_of(findings, late);
  EXPECT_EQ(of_kind(findings, "delay_unknown").size(), 1u) << text_of(findings, late);
}

// Every twentieth sample of a log at 1 kHz, torque as it was at that instant.
TEST(Doctor, ASlowLogWithoutDelayHasNone) {
  const Dataset slow = decimated(fast_log().data, 20);
  EXPECT_EQ(text_of(diagnose(slow, &fast_log().robot), slow), "");
}

// Reference: the corner of the filter that was put in. A filter of second order is as late as one
// of first order with a corner at 1 / sqrt(2) of its own.
TEST(Doctor, ATorqueThroughAFilterIsNotOnlyLate) {
  const auto& [log, robot] = fast_log();
  for (const double corner_hz : {2.0, 3.0})
    for (const int order : {1, 2}) {
      SCOPED_TRACE(fmt::format("{} Hz, order {}", corner_hz, order));
      Dataset filtered = log;
      const double w = 2 * std::numbers::pi * corner_hz * log.dt();
      for (int j = 0; j < 6; ++j) {
        double x = log.tau(0, j), rate = 0;  // damping of second order: 1 / sqrt(2)
        for (int k = 0; k < log.length(); ++k) {
          const double beyond = log.tau(k, j) - x;
          rate = order == 1 ? w * beyond : rate + w * (w * beyond - std::numbers::sqrt2 * rate);
          filtered.tau(k, j) = x += rate;
        }
      }
      const std::vector<Finding> findings = diagnose(filtered, &robot);
      EXPECT_TRUE(of_kind(findings, "delay").empty());
      const std::vector<Finding> found = of_kind(findings, "low_pass");
      ASSERT_EQ(found.size(), 1u) << text_of(findings, filtered);
      const double size =
          found[0].size / (order == 1 ? corner_hz : corner_hz / std::numbers::sqrt2);
      EXPECT_GT(size, 0.6);  // friction is late too
      EXPECT_LT(size, 1.2);
      EXPECT_FALSE(can_be_repaired(found[0]));
    }
}

}  // namespace
}  // namespace fricid::doctor
