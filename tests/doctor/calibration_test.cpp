// A small version of the table of docs/doctor.md: damage put into three logs at random.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "doctor/clean_logs.hpp"
#include "doctor/injected.hpp"
#include "fricid/dynamics/algorithms.hpp"
#include "fricid/dynamics/workspace.hpp"

namespace fricid::doctor {
namespace {

constexpr int kEvery = 4;  // of 1 kHz

TEST(DoctorCalibration, FindsDamageOfEveryKindAndNoneWhereThereIsNone) {
  int damaged = 0, found = 0, others = 0;
  for (const int arm : {1, 6, 13}) {
    const CleanLog clean = simulate_log(arm);
    for (std::size_t kind = 0; kind < injections().size(); ++kind) {
      const Injection& injection = injections()[kind];
      SCOPED_TRACE(clean.what + ": " + injection.what);
      data::Dataset d = decimated(clean.data, kEvery);
      dynamics::RobotModel robot = clean.robot;
      Rng rng(29, 100 * static_cast<std::uint64_t>(arm) + kind);
      Injected truth = injection.apply(d, robot, rng);
      if (truth.name == "delay") truth.samples += 0.5 * (1 - 1. / kEvery);
      const Judged judged = judge(d, robot, truth);
      if (injection.harmless) {
        EXPECT_EQ(judged.said, "");
        continue;
      }
      ++damaged;
      found += judged.found;
      others += judged.others > 0;
      if (!judged.found || judged.others > 0)
        fmt::print("{}: {}:\n{}", clean.what, injection.what, judged.said);
      if (truth.name == "delay" && judged.found) {
        EXPECT_LT(std::abs(judged.delay_error), 0.75);
      }
    }
  }
  EXPECT_EQ(damaged, 3 * 34);
  EXPECT_GE(found, 94);
  EXPECT_LE(others, 4);
}

// A robot that is said to stand while it hangs: gravity then hides a turned torque of joint_a2.
TEST(DoctorCalibration, AWrongMountHidesNoSign) {
  const CleanLog hanging = simulate_log(9);
  data::Dataset d = decimated(hanging.data, kEvery);
  dynamics::RobotModel standing = hanging.robot;
  standing.gravity *= -1;
  EXPECT_TRUE(judge(d, standing, {"mount"}).found);
  EXPECT_EQ(judge(d, standing, {"mount"}).others, 0);
  d.tau.col(1) *= -1;
  EXPECT_TRUE(judge(d, standing, {"mount"}).found);
  EXPECT_TRUE(judge(d, standing, {"sign", 1}).found);
  EXPECT_TRUE(judge(d, hanging.robot, {"sign", 1}).found);
  EXPECT_EQ(judge(d, hanging.robot, {"sign", 1}).others, 0);
}

// A driver that takes the weight of the arm off the torque that it logs.
TEST(DoctorCalibration, FindsTorqueWithoutGravity) {
  const CleanLog clean = simulate_log(6);
  data::Dataset d = decimated(clean.data, kEvery);
  const auto n = static_cast<std::size_t>(d.n());
  const Eigen::VectorXd still = Eigen::VectorXd::Zero(d.n());
  dynamics::Workspace<double> ws(clean.robot);
  Eigen::RowVectorXd weight(d.n());
  for (Eigen::Index k = 0; k < d.q.rows(); ++k) {
    dynamics::rnea<double>(
        clean.robot, ws, {clean.robot.pi.data(), static_cast<std::size_t>(clean.robot.pi.size())},
        {d.q.row(k).data(), n}, {still.data(), n}, {still.data(), n}, {weight.data(), n});
    d.tau.row(k) -= weight;
  }
  const Judged judged = judge(d, clean.robot, {"no_gravity"});
  EXPECT_TRUE(judged.found) << judged.said;
  EXPECT_EQ(judged.others, 0) << judged.said;
}

// Joints in the order of another program, last first: each pair is named, and --fix swaps it.
TEST(DoctorCalibration, FindsAllJointsInReversedOrder) {
  for (const int arm : {0, 5, 6, 14}) {
    const CleanLog clean = simulate_log(arm);
    data::Dataset d = decimated(clean.data, kEvery);
    for (data::RowMatrix* x : {&d.q, &d.v, &d.tau})
      if (x->size() > 0) *x = data::RowMatrix(x->rowwise().reverse());
    for (int j = 0; j < d.n() - 1 - j; ++j) {
      const Judged judged = judge(d, clean.robot, {"swapped", j});
      EXPECT_TRUE(judged.found) << clean.what << ", joint " << j << ": " << judged.said;
      EXPECT_EQ(judged.others, 0) << clean.what << ": " << judged.said;
    }
  }
}

// Limits that a converter of URDFs put in for all joints, narrower than the motion: the torque
// tells that no position is in degrees.
TEST(DoctorCalibration, NarrowLimitsAreNoDegreesWhereTheTorqueContradicts) {
  const CleanLog clean = simulate_log(6);
  const data::Dataset d = decimated(clean.data, kEvery);
  dynamics::RobotModel robot = clean.robot;
  int beyond = 0;
  for (int j = 0; j < robot.n(); ++j) {
    dynamics::Joint& joint = robot.joints[static_cast<std::size_t>(j)];
    joint.lower = -0.1, joint.upper = 0.1;
    beyond += d.q.col(j).cwiseAbs().maxCoeff() > 0.7;
  }
  ASSERT_GT(beyond, 0);
  const std::vector<Finding> findings = diagnose(d, &robot);
  EXPECT_EQ(text_of(findings, d), "");
  EXPECT_EQ(std::ranges::count(findings, FindingKind::kBeyondLimit, &Finding::kind), robot.n());
}

// A torque that leads by more than is searched.
TEST(DoctorCalibration, ATorqueThatLeadsByFarIsSaid) {
  const CleanLog clean = simulate_log(0);
  data::Dataset d = decimated(clean.data, kEvery);
  delay_torque(d, -0.05 * d.rate_hz);
  EXPECT_TRUE(judge(d, clean.robot, {"delay_unknown"}).found)
      << judge(d, clean.robot, {"delay_unknown"}).said;
}

// One clock logs all of a campaign: what leads in one of three logs alone does not.
TEST(DoctorCalibration, ATorqueLeadsInMostLogsOrInNone) {
  const CleanLog clean = simulate_log(0);
  const data::Dataset whole = decimated(clean.data, kEvery);
  data::Dataset leading = whole;
  delay_torque(leading, -0.05 * leading.rate_hz);
  const auto said = [&](const std::vector<data::Dataset>& logs) {
    std::ptrdiff_t count = 0;
    for (const std::vector<Finding>& findings : diagnose(logs, &clean.robot))
      count += std::ranges::count(findings, FindingKind::kDelayUnknown, &Finding::kind);
    return count;
  };
  EXPECT_EQ(said({whole, leading, whole}), 0);
  EXPECT_EQ(said({leading, leading, whole}), 2);
}

// Five seconds of slow motion, in which friction that lags leaves the shift of the torque open.
TEST(DoctorCalibration, AShortSlowLogHasADelayBeyondTheSearchOnlyWhereOneWasPutIn) {
  const CleanLog slow = simulate_log(4);
  for (const double late_s : {0.0, 0.4}) {
    data::Dataset d = decimated(slow.data, kEvery);
    delay_torque(d, late_s * d.rate_hz);
    const auto rows = Eigen::seqN(0, static_cast<Eigen::Index>(5 * d.rate_hz));
    d.t = Eigen::VectorXd(d.t(rows));
    for (data::RowMatrix* x : {&d.q, &d.tau, &d.v, &d.temperature})
      *x = data::RowMatrix((*x)(rows, Eigen::all));
    const Judged judged = judge(d, slow.robot, {"delay_unknown"});
    EXPECT_EQ(judged.found, late_s > 0) << judged.said;
    EXPECT_EQ(judged.others, 0) << judged.said;
  }
}

/// Samples from a time on, for some seconds.
data::Dataset window_of(const data::Dataset& whole, double from_s, double seconds) {
  data::Dataset d = whole;
  const auto rows = Eigen::seqN(static_cast<Eigen::Index>(from_s * d.rate_hz),
                                static_cast<Eigen::Index>(seconds * d.rate_hz));
  d.t = Eigen::VectorXd(d.t(rows));
  d.t.array() -= d.t[0];
  for (data::RowMatrix* x : {&d.q, &d.tau, &d.v, &d.temperature})
    if (x->rows() > 0) *x = data::RowMatrix((*x)(rows, Eigen::all));
  return d;
}

// Three seconds of friction that lags look like a delay of a tenth of a second by chance.
TEST(DoctorCalibration, AShortLogHasNoDelayByChance) {
  int windows = 0, found = 0;
  for (const int arm : {0, 1, 2, 6, 9, 13}) {
    const CleanLog clean = simulate_log(arm);
    const data::Dataset whole = decimated(clean.data, kEvery);
    const double length = whole.t[whole.length() - 1];
    for (double from = 0; from + 3 < length; from += 3) {
      const std::string said = judge(window_of(whole, from, 3), clean.robot, {"delay"}).said;
      EXPECT_EQ(said.find("delay"), std::string::npos) << clean.what << from << said;
      ++windows;
    }
    data::Dataset late = whole;
    delay_torque(late, 0.02 * late.rate_hz);
    found += judge(window_of(late, 0, std::min(length, 12.0)), clean.robot,
                   {"delay", -1, 0.02 * late.rate_hz})
                 .found;
  }
  EXPECT_GE(windows, 28);
  EXPECT_GE(found, 5);  // of 6
}

// The spindle of a SCARA in millimetres; where the other joints are in degrees, 0.0573 of that.
TEST(DoctorCalibration, ASlidingJointThatIsNotInMetresIsNamed) {
  const CleanLog scara = simulate_log(7);
  for (const double factor : {1000.0, 1000 * 3.14159 / 180}) {
    data::Dataset d = decimated(scara.data, kEvery);
    d.q.col(2) *= factor;
    d.v.col(2) *= factor;
    const Judged judged = judge(d, scara.robot, {"length_unit", 2});
    EXPECT_TRUE(judged.found) << judged.said;
    EXPECT_EQ(judged.others, 0) << judged.said;
  }
}

TEST(DoctorCalibration, SizesOfASlidingJointAreForcesAndLengths) {
  const CleanLog scara = simulate_log(7);
  data::Dataset d = decimated(scara.data, kEvery);
  const double most = 0.7 * d.tau.col(2).cwiseAbs().maxCoeff();
  d.tau.col(2) = d.tau.col(2).cwiseMax(-most).cwiseMin(most);
  d.tau.col(0) = d.tau.col(0).cwiseMin(0.5 * d.tau.col(0).maxCoeff());
  d.q(d.length() / 2, 2) += 0.05;
  int sliding = 0, turning = 0;
  for (const Finding& f : diagnose(d, &scara.robot)) {
    const bool slides = f.joint == 2, spike = f.kind == FindingKind::kSpike;
    if (!spike && f.kind != FindingKind::kSaturated) continue;
    EXPECT_EQ(f.unit, spike ? "m" : slides ? "N" : "N m");
    ++(slides ? sliding : turning);
  }
  EXPECT_GE(sliding, 2);
  EXPECT_EQ(turning, 1);
}

}  // namespace
}  // namespace fricid::doctor
