// Faults of one signal: stuck, saturated, constant, repeated, beyond its limits; and what only
// looks like one.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>

#include "doctor/clean_logs.hpp"
#include "doctor/injected.hpp"
#include "fricid/base/not_finite.hpp"
#include "fricid/base/rng.hpp"
#include "fricid/doctor/doctor.hpp"

namespace fricid::doctor {
namespace {

using data::Dataset;
using data::RowMatrix;

/// The log slowed down to a stop over the last second, and standing still for two more.
Dataset come_to_rest(const Dataset& log) {
  Dataset d = log;
  const int T = d.length(), still = static_cast<int>(2 * d.rate_hz),
            slow = static_cast<int>(1 * d.rate_hz), from = T - still - slow;
  double phase = from;  // row of the log that is shown
  for (int k = from; k < T; ++k) {
    const int row = static_cast<int>(phase);
    const double share = phase - row;
    for (RowMatrix* x : {&d.q, &d.tau, &d.v})
      if (x->size() > 0)
        x->row(k) = (1 - share) * (x == &d.q   ? log.q
                                   : x == &d.v ? log.v
                                               : log.tau)
                                      .row(row) +
                    share * (x == &d.q   ? log.q
                             : x == &d.v ? log.v
                                         : log.tau)
                                .row(row + 1);
    const double speed = std::max(0.0, 1 - static_cast<double>(k - from) / slow);
    if (d.v.size() > 0) d.v.row(k) *= speed;
    if (speed == 0)
      for (RowMatrix* x : {&d.q, &d.tau, &d.v})
        if (x->size() > 0) x->row(k) = x->row(k - 1).eval();
    phase += speed;
  }
  return d;
}

TEST(Doctor, AnArmThatComesToRestIsNotStuck) {
  for (const std::size_t i : {0u, 5u, 13u}) {
    const Dataset d = come_to_rest(clean_logs()[i].data);
    const auto findings = diagnose(d, &clean_logs()[i].robot);
    EXPECT_TRUE(of_kind(findings, "stuck").empty()) << text_of(findings, d);
  }
}

// It rests, and the arm has moved on when samples come again.
TEST(Doctor, AnArmThatRestsBeforeAGapIsNotStuck) {
  for (const bool lacks_rows : {true, false}) {
    const Dataset rested = come_to_rest(clean_logs()[0].data);
    int end = rested.length() - 1;
    for (int k = 1; k + 1 < rested.length(); ++k)
      if (rested.q.row(k) == rested.q.row(k - 1) && rested.q.row(k) == rested.q.row(k + 1)) end = k;
    Dataset d = rested;
    constexpr int kLost = 400;
    Dataset moving = clean_logs()[0].data;
    const int before = end - 200, after = 1500;
    const auto put = [&](data::RowMatrix Dataset::*x) {
      if ((rested.*x).size() == 0) return;
      data::RowMatrix& out = d.*x;
      const Eigen::Index gap = lacks_rows ? 0 : kLost;
      out.resize(before + gap + after, rested.n());
      out.topRows(before) = (rested.*x).topRows(before);
      out.middleRows(before, gap).setConstant(kNan);
      out.bottomRows(after) = (moving.*x).topRows(after);
    };
    for (data::RowMatrix Dataset::*x :
         {&Dataset::q, &Dataset::tau, &Dataset::v, &Dataset::temperature})
      put(x);
    d.t.resize(d.q.rows());
    for (Eigen::Index k = 0; k < d.t.size(); ++k)
      d.t[k] = static_cast<double>(k + (lacks_rows && k >= before ? kLost : 0)) / d.rate_hz;
    const auto findings = diagnose(d, &clean_logs()[0].robot);
    EXPECT_TRUE(of_kind(findings, "stuck").empty()) << text_of(findings, d);
  }
}

TEST(Doctor, APositionThatFreezesUntilTheEndIsStuck) {
  Dataset d = clean_logs()[0].data;
  int k = d.length() - 1200;  // where joint 6 is fast
  for (int i = k; i < k + 300; ++i)
    if (std::abs(d.q(i + 1, 5) - d.q(i, 5)) > std::abs(d.q(k + 1, 5) - d.q(k, 5))) k = i;
  d.q.col(5).tail(d.length() - k).setConstant(d.q(k, 5));
  const auto found = of_kind(diagnose(d, &clean_logs()[0].robot), "stuck");
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0].joint, 5);
  EXPECT_EQ(found[0].signal, "q");
}

/// One joint along q(t), by an encoder of some step [rad], with a torque that has noise.
Dataset log_of(const std::function<double(double)>& q, double seconds, double rate_hz,
               double step) {
  Rng rng(3, 0);
  Dataset d;
  d.name = "one joint";
  d.joint_names = {"j1"};
  d.rate_hz = rate_hz;
  const auto length = static_cast<Eigen::Index>(seconds * rate_hz);
  d.t = Eigen::VectorXd::LinSpaced(length, 0, static_cast<double>(length - 1)) / rate_hz;
  d.q.resize(length, 1);
  d.tau.resize(length, 1);
  for (Eigen::Index k = 0; k < length; ++k) {
    const double t = d.t[k], speed = (q(t + 1e-4) - q(t - 1e-4)) / 2e-4;
    d.q(k, 0) = std::round(q(t) / step) * step;
    d.tau(k, 0) = 3 * std::sin(q(t)) + 2 * std::tanh(100 * speed) + speed + 0.01 * rng.normal();
  }
  return d;
}

/// By `travel` along a quintic from 1 s to 7 s.
double quintic_move(double t, double travel) {
  const double s = std::clamp((t - 1) / 6, 0.0, 1.0);
  return travel * s * s * s * (10 - 15 * s + 6 * s * s);
}

constexpr double kCountsOf4096 = 2 * std::numbers::pi / 4096;
constexpr double kHundredthDegree = 0.01 * std::numbers::pi / 180;

TEST(Doctor, ACoarseEncoderThatComesToRestIsNeitherStuckNorSaturated) {
  for (const double step : {kCountsOf4096, kHundredthDegree, 0.1 * kHundredthDegree})
    for (const double rate_hz : {50.0, 200.0, 1000.0})
      for (const double travel : {0.05, 0.3, 1.5}) {
        SCOPED_TRACE(fmt::format("step {} rad, {} Hz, {} rad", step, rate_hz, travel));
        const Dataset d =
            log_of([&](double t) { return quintic_move(t, travel); }, 12, rate_hz, step);
        const auto findings = diagnose(d);
        EXPECT_TRUE(of_kind(findings, "stuck").empty()) << text_of(findings, d);
        EXPECT_TRUE(of_kind(findings, "saturated").empty()) << text_of(findings, d);
      }
}

TEST(Doctor, ACoarseEncoderIsNotSaturatedWhereTheJointReverses) {
  for (const double amplitude : {0.02, 0.1, 0.5}) {
    const Dataset d =
        log_of([&](double t) { return amplitude * std::sin(1.3 * t); }, 30, 200, kCountsOf4096);
    EXPECT_TRUE(of_kind(diagnose(d), "saturated").empty()) << text_of(diagnose(d), d);
  }
}

TEST(Doctor, ACoarseEncoderThatFreezesInMotionIsStuck) {
  for (const double step : {kCountsOf4096, kHundredthDegree})
    for (const double rate_hz : {50.0, 200.0, 1000.0}) {
      SCOPED_TRACE(fmt::format("step {} rad, {} Hz", step, rate_hz));
      const Dataset d =
          log_of([](double t) { return quintic_move(std::min(t, 4.0), 1.5); }, 12, rate_hz, step);
      EXPECT_EQ(of_kind(diagnose(d), "stuck").size(), 1u) << text_of(diagnose(d), d);
    }
}

// Fits take the speed from the position.
TEST(Doctor, AVelocityThatIsCoarseOrPartlyLoggedIsNoDamage) {
  const auto& clean = clean_logs()[0];
  Dataset coarse = clean.data, sparse = clean.data;
  coarse.v = (coarse.v.array() / 0.05).round() * 0.05;
  for (int k = 0; k < sparse.length(); ++k)
    if (k % 5 != 0) sparse.v.row(k).setConstant(std::numeric_limits<double>::quiet_NaN());
  for (const Dataset& d : {coarse, sparse}) {
    const std::vector<Finding> findings = diagnose(d, &clean.robot);
    EXPECT_EQ(std::ranges::count_if(findings, is_damage), 0) << text_of(findings, d);
  }
}

TEST(Doctor, TorqueAtItsLimitForAShareOfTheLogMisleadsAndCanBeLeftOut) {
  auto [log, robot] = clean_logs()[0];
  const double most = 0.5 * log.tau.col(0).cwiseAbs().maxCoeff();
  log.tau.col(0) = log.tau.col(0).cwiseMax(-most).cwiseMin(most);
  const auto findings = of_kind(diagnose(log, &robot), "saturated");
  ASSERT_FALSE(findings.empty());
  for (const Finding& found : findings)
    EXPECT_EQ(misleads(found), found.count > 0.01 * log.length()) << found.count;
  EXPECT_TRUE(std::ranges::any_of(findings, misleads));
  const Dataset repaired = repair(log, findings, {{FindingKind::kSaturated}});
  for (int k = 0; k < log.length(); ++k)
    EXPECT_EQ(std::isnan(repaired.tau(k, 0)), std::abs(log.tau(k, 0)) == most) << k;
}

// Wherever the level cuts the torque: on a slope, or where it hardly changes and as many samples
// lie just below. One run that ends in a leap is a channel that stuck.
TEST(Doctor, TorqueClippedAtAnyLevelIsDamage) {
  const auto& [clean, robot] = clean_logs()[0];
  for (int j = 0; j < clean.n(); ++j)
    for (const double share : {0.035, 0.06, 0.09, 0.15, 0.3}) {
      Dataset log = clean;
      std::vector<double> sorted(log.tau.col(j).begin(), log.tau.col(j).end());
      std::ranges::sort(sorted);
      const double least = sorted[static_cast<std::size_t>(share * log.length())];
      log.tau.col(j) = log.tau.col(j).cwiseMax(least);
      const std::vector<Finding> findings = diagnose(log, &robot);
      EXPECT_TRUE(std::ranges::any_of(
          findings,
          [&](const Finding& f) {
            const bool named = f.kind == FindingKind::kSaturated || f.kind == FindingKind::kStuck;
            return named && f.signal == "tau" && f.joint == j && misleads(f);
          }))
          << "joint " << j + 1 << " at " << share << ": " << text_of(findings, log);
    }
}

TEST(Doctor, TorqueAtTheLimitOfTheDriveIsNoDamage) {
  auto [log, robot] = clean_logs()[0];
  const double most = 0.5 * log.tau.col(0).cwiseAbs().maxCoeff();
  log.tau.col(0) = log.tau.col(0).cwiseMax(-most).cwiseMin(most);
  robot.joints[0].effort = 1.005 * most;
  const std::vector<Finding> findings = diagnose(log, &robot);
  EXPECT_TRUE(of_kind(findings, "saturated").empty()) << text_of(findings, log);
  const auto at_limit = of_kind(findings, "at_limit");
  ASSERT_FALSE(at_limit.empty()) << text_of(findings, log);
  for (const Finding& found : at_limit) {
    EXPECT_FALSE(is_damage(found) || misleads(found));
    EXPECT_TRUE(is_told(found));
    EXPECT_EQ(found.joint, 0);
    EXPECT_THAT(to_text(found, log), testing::HasSubstr("the drive was at its limit"));
  }
  robot.joints[0].effort = 1.02 * most;
  EXPECT_TRUE(of_kind(diagnose(log, &robot), "at_limit").empty());
  EXPECT_FALSE(of_kind(diagnose(log, &robot), "saturated").empty());
}

TEST(Doctor, PositionsBeyondTheLimitsOfTheFileAreTold) {
  auto [log, robot] = clean_logs()[0];
  const double most = log.q.col(2).maxCoeff();
  robot.joints[2].upper = most - 0.05;
  const std::vector<Finding> findings = diagnose(log, &robot);
  const std::vector<Finding> found = of_kind(findings, "beyond_limit");
  ASSERT_EQ(found.size(), 1u) << text_of(findings, log);
  EXPECT_EQ(found[0].joint, 2);
  EXPECT_NEAR(found[0].size, most, 1e-3);
  EXPECT_FALSE(is_damage(found[0]));
  EXPECT_TRUE(is_told(found[0]));
}

TEST(Doctor, ATorqueThatWasNotLoggedIsConstant) {
  for (const double value : {0.0, -3.5})
    for (const bool with_robot : {true, false}) {
      Dataset d = clean_logs()[0].data;
      d.tau.col(1).setConstant(value);
      const std::vector<Finding> findings =
          diagnose(d, with_robot ? &clean_logs()[0].robot : nullptr);
      const auto constant = of_kind(findings, "constant");
      ASSERT_EQ(constant.size(), 1u) << text_of(findings, d);
      EXPECT_EQ(constant[0].joint, 1);
      EXPECT_EQ(constant[0].signal, "tau");
      EXPECT_EQ(constant[0].size, value);
      EXPECT_EQ(std::ranges::count_if(findings, is_damage), 1) << text_of(findings, d);
    }
}

TEST(Doctor, ATorqueThatIsMissingThroughoutContradictsNoVelocity) {
  Dataset d = clean_logs()[0].data;
  d.tau.col(1).setConstant(std::nan(""));
  const std::vector<Finding> findings = diagnose(d, &clean_logs()[0].robot);
  EXPECT_EQ(of_kind(findings, "missing").size(), 1u) << text_of(findings, d);
  EXPECT_TRUE(of_kind(findings, "velocity").empty()) << text_of(findings, d);
}

// Two joints that rest at one position, and two torques that were not logged.
TEST(Doctor, ATorqueWithoutItsSignIsNamed) {
  Dataset d = clean_logs()[0].data;
  d.tau = d.tau.cwiseAbs();
  d.tau.col(2) *= -1;
  const auto findings = diagnose(d, &clean_logs()[0].robot);
  const auto found = of_kind(findings, "unsigned");
  EXPECT_GE(std::ssize(found), d.n() - 1) << text_of(findings, d);
  EXPECT_TRUE(std::ranges::all_of(found, misleads));
}

TEST(Doctor, ColumnsThatDoNotChangeAreNotTheSame) {
  Dataset d = clean_logs()[0].data;
  for (const int j : {3, 4}) {
    d.q.col(j).setConstant(0.4);
    d.v.col(j).setZero();
    d.tau.col(j).setZero();
  }
  const auto findings = diagnose(d, &clean_logs()[0].robot);
  EXPECT_TRUE(of_kind(findings, "same").empty()) << text_of(findings, d);
}

TEST(Doctor, AJointThatStandsStillIsNamedSo) {
  Dataset d = clean_logs()[0].data;
  d.q.col(3).setConstant(0.4);
  const auto findings = diagnose(d, &clean_logs()[0].robot);
  ASSERT_EQ(of_kind(findings, "still").size(), 1u);
  EXPECT_EQ(of_kind(findings, "still")[0].joint, 3);
  EXPECT_TRUE(of_kind(findings, "stuck").empty());
}

// At a low rate a joint moves far in a sample, and not at all between a row and its copy.
TEST(Doctor, ARowTwiceIsNoJump) {
  constexpr int kTwice = 401;
  Dataset d = decimated(clean_logs()[0].data, 2);
  Rng rng(1, 0);
  for (int k = 0; k < d.length(); ++k)  // to and fro at one speed
    for (int j = 0; j < d.n(); ++j)
      d.q(k, j) = 0.4 * std::asin(std::sin(3 * d.t[k] + j)) + 1e-6 * rng.normal();
  for (int k = d.length() - 1; k > kTwice; --k) {
    d.t[k] = d.t[k - 1];
    for (RowMatrix* x : {&d.q, &d.tau, &d.v, &d.temperature})
      if (x->size() > 0) x->row(k) = x->row(k - 1).eval();
  }
  const std::vector<Finding> found = diagnose(d);
  EXPECT_EQ(of_kind(found, "duplicate").size(), 1u) << text_of(found, d);
  EXPECT_TRUE(of_kind(found, "jump").empty()) << text_of(found, d);
}

// Three rows in a row that are stale, of irregular packets, count all.
TEST(Doctor, StaleRowsInARowAreAllCounted) {
  Dataset d = clean_logs()[0].data;
  int stale = 0;
  for (int k = 30; k + 30 < d.length(); k += 17 + k % 5, stale += 3)
    for (int i = 1; i < 4; ++i)
      for (RowMatrix* x : {&d.q, &d.v, &d.tau}) x->row(k + i) = x->row(k).eval();
  const auto found = of_kind(diagnose(d), "repeated");
  ASSERT_EQ(found.size(), 1u) << text_of(diagnose(d), d);
  EXPECT_NEAR(found[0].count, stale, 0.1 * stale);
}

// Twenty minutes of a torque in steps: every value is repeated, and none of the runs is looked at
// by going through the log again, which would take hours.
TEST(Doctor, ALongLogOfTorqueInStepsIsReadThroughOnce) {
  constexpr int kSamples = 1'200'000;
  Dataset d;
  d.name = "long";
  d.joint_names = {"j1"};
  d.rate_hz = 1000;
  d.t = Eigen::VectorXd::LinSpaced(kSamples, 0, (kSamples - 1) * 1e-3);
  d.q.resize(kSamples, 1);
  d.tau.resize(kSamples, 1);
  for (int k = 0; k < kSamples; ++k) {
    const double phase = 1.7 * d.t[k];
    d.q(k, 0) = 0.8 * std::sin(phase);
    d.tau(k, 0) = std::round(20 * std::sin(d.q(k, 0)) + 3 * std::cos(phase));
  }
  const auto findings = diagnose(d, nullptr);
  EXPECT_TRUE(of_kind(findings, "stuck").empty()) << text_of(findings, d);
}

}  // namespace
}  // namespace fricid::doctor
