#include "fricid/evaluate/contact.hpp"

#include <gmock/gmock.h>

#include <cmath>

#include "fricid/evaluate/compensation.hpp"
#include "fricid/evaluate/reversals.hpp"

namespace fricid::evaluate {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

constexpr double kRate = 10;  // [Hz]

/// Two hours of +-1 and +-10 N m at two joints, and three seconds in which one has more.
QuietTorque two_hours() {
  RowMatrix tau_ext(static_cast<Eigen::Index>(7200 * kRate), 2);
  for (Eigen::Index k = 0; k < tau_ext.rows(); ++k) {
    tau_ext(k, 0) = k % 2 == 0 ? 1 : -1;
    tau_ext(k, 1) = 10 * tau_ext(k, 0);
  }
  tau_ext(3, 0) = 5;
  tau_ext(1005, 1) = -40;
  tau_ext(5005, 0) = 3;
  QuietTorque quiet, more;
  const Eigen::Index half = tau_ext.rows() / 2;
  quiet.add(tau_ext.topRows(half), kRate);
  more.add(tau_ext.bottomRows(half), kRate);
  quiet.add(more);
  return quiet;
}

// Two alarms are allowed in two hours: the third largest second is the threshold.
TEST(Contact, TheThresholdLetsOneSecondOfAnHourPass) {
  const QuietTorque quiet = two_hours();
  EXPECT_DOUBLE_EQ(quiet.hours(), 2);
  EXPECT_NEAR(quiet.sd()[0], 1, 1e-3);
  EXPECT_NEAR(quiet.sd()[1], 10, 1e-2);
  EXPECT_NEAR(quiet.threshold(), 3, 1e-2);
}

TEST(Contact, DelaysEndAtTheFirstAlarmOfAnyJoint) {
  RowMatrix tau_ext = RowMatrix::Zero(40, 2);
  tau_ext(12, 1) = -6;
  tau_ext(29, 0) = 6;
  const std::vector<PushSpan> pushes{{10, 15}, {20, 25}, {29, 35}};
  const std::vector<double> found = delays(tau_ext, pushes, kRate, std::vector{5.0, 5.0});
  EXPECT_THAT(found, ElementsAre(0.2, HUGE_VAL, 0.0));
  const PushScore score = score_pushes(20, found);
  EXPECT_EQ(score.missed, 1);
  EXPECT_EQ(score.delay_median_s, 0.2);
  EXPECT_EQ(score.delay_90_s, HUGE_VAL);
}

TEST(Contact, ErrorsAreByRegime) {
  RowMatrix v(100, 1), error(100, 1);
  for (Eigen::Index k = 0; k < 100; ++k) {
    v(k, 0) = k < 50 ? 1 : -1;
    error(k, 0) = k >= 50 && k < 52 ? 3 : 1;  // 0.2 s at 10 Hz
  }
  TorqueErrors errors;
  errors.add(error, RowMatrix::Zero(100, 1), v, 1 / kRate);
  ContactScore score;
  errors.write(score);
  EXPECT_DOUBLE_EQ(score.rmse_reversal_Nm[0], 3);
  EXPECT_DOUBLE_EQ(score.rmse_sliding_Nm[0], 1);
  EXPECT_NEAR(score.rmse_Nm[0], std::sqrt(1.16), 1e-12);
}

TEST(Contact, TheTableHasARowPerModel) {
  ContactFile file;
  file.hours = 1;
  file.bandwidth_hz = 10;
  for (const auto& [model, threshold] : {std::pair("lvm", 2.0), std::pair(kTruthModel, 1.0)}) {
    ContactScore& score = file.models.emplace_back();
    score.model = score.label = model;
    score.threshold_Nm = {threshold};
    score.rmse_Nm = score.rmse_reversal_Nm = score.rmse_sliding_Nm = {0.3};
    score.forces = {score_pushes(20, std::vector(9, HUGE_VAL))};
  }
  const std::string text = to_markdown(file);
  EXPECT_THAT(text, HasSubstr("| lvm "));
  EXPECT_THAT(text, HasSubstr("missed |"));
  EXPECT_THAT(text, HasSubstr(" 9/9 |"));
}

}  // namespace
}  // namespace fricid::evaluate
