// A push is named with its time; friction that a law lacks, which comes back at every reversal, is
// not.
#include <gmock/gmock.h>

#include "fit_of_logs.hpp"

namespace fricid::estimate {
namespace {

using testing::HasSubstr;

/// The log while something pushes two joints for a time.
data::Dataset pushed(data::Dataset log, double at_s, double torque, double seconds = 0.3) {
  for (int k = 0; k < log.length(); ++k)
    if (log.t[k] >= at_s && log.t[k] < at_s + seconds) {
      log.tau(k, 1) -= torque;
      log.tau(k, 2) -= torque / 2;
    }
  return log;
}

TEST(Disturbances, APushIsNamedWithItsTime) {
  const Arm arm = lugre_arm();
  data::Dataset log = pushed(noisy_log(arm), 5, 8);
  log.name = "log";
  const FitReport report = fit(arm.robot, {log}, "lugre");
  EXPECT_TRUE(report.usable()) << text_of(report.faults);
  ASSERT_TRUE(report.disturbances);
  EXPECT_THAT(report.disturbances->found, HasSubstr("times as much as ever else"));
  EXPECT_THAT(report.disturbances->found,
              testing::ContainsRegex("(4.[89]|5)[0-9]* to 5.[34][0-9]* s of log"));
  EXPECT_THAT(report.disturbances->found, testing::ContainsRegex("j2 by [0-9.]* N m"));
  EXPECT_THAT(report.disturbances->remedy,
              testing::ContainsRegex("train = ..LOG.:4.[0-9]*.., .LOG.5.[0-9]*:"));
  const data::FitFile file = fit_file(report);
  ASSERT_TRUE(file.remarks);
  EXPECT_EQ(file.remarks->back().found, report.disturbances->found);
}

TEST(Disturbances, ReversalsThatALawLacksAreNone) {
  const Arm arm = lugre_arm();
  for (const char* law : {"simple", "stribeck", "lugre"})
    EXPECT_FALSE(fit(arm.robot, {noisy_log(arm)}, law).disturbances) << law;
}

// A recording begins with springs that are bent nobody knows how, and cables stay so for longer.
TEST(Disturbances, TheBeginningOfALogIsNone) {
  const Arm arm = lugre_arm();
  EXPECT_TRUE(fit(arm.robot, {pushed(noisy_log(arm), 5, 8)}, "lugre").disturbances);
  for (const double seconds : {0.3, 1.5})
    EXPECT_FALSE(fit(arm.robot, {pushed(noisy_log(arm), 0.05, 8, seconds)}, "lugre").disturbances);
}

// Two that fill more than half of a log are no events.
TEST(Disturbances, WhatFillsALogIsNone) {
  const Arm arm = lugre_arm();
  const data::Dataset log = noisy_log(arm);
  const double end = log.t[log.length() - 1];
  const auto found = [&](double share) {
    const data::Dataset once = pushed(log, 0.1 * end, 20, share * end);
    return fit(arm.robot, {pushed(once, 0.55 * end, 20, share * end)}, "lugre").disturbances;
  };
  EXPECT_TRUE(found(0.03));
  EXPECT_FALSE(found(0.35));
}

// Of a joint that reverses a few times, one unlike the others says nothing.
TEST(Disturbances, AFewReversalsTellNone) {
  const Arm arm = lugre_arm();
  data::Dataset log = pushed(noisy_log(arm), 0.6, 8);
  const int short_log = 400;
  for (RowMatrix data::Dataset::*signal : {&data::Dataset::q, &data::Dataset::tau})
    (log.*signal).conservativeResize(short_log, Eigen::NoChange);
  log.t.conservativeResize(short_log);
  EXPECT_FALSE(fit(arm.robot, {log}, "lugre").disturbances);
}

}  // namespace
}  // namespace fricid::estimate
