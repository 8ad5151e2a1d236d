#include <gmock/gmock.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "fricid/base/error.hpp"
#include "fricid/base/rng.hpp"
#include "fricid/doctor/doctor.hpp"

namespace fricid::doctor {
namespace {

data::Dataset log_with_a_gap(double seconds) {
  constexpr int kLength = 100;
  data::Dataset d;
  d.name = "log";
  d.joint_names = {"a"};
  d.rate_hz = 100;
  d.t = Eigen::VectorXd::LinSpaced(kLength, 0, 0.99);
  d.t.tail(50).array() += seconds;
  d.q = d.tau = data::RowMatrix::Random(kLength, 1);
  return d;
}

std::vector<Finding> gap() { return {{.kind = FindingKind::kGap, .signal = "t"}}; }

TEST(Repair, FillsAGapWithMissingSamples) {
  const std::vector<FindingKind> kinds{FindingKind::kGap};
  const data::Dataset d = repair(log_with_a_gap(0.2), gap(), kinds);
  ASSERT_EQ(d.length(), 120);
  EXPECT_TRUE(std::isfinite(d.q(49, 0)));
  for (int k = 50; k < 70; ++k) EXPECT_TRUE(std::isnan(d.q(k, 0))) << k;
  EXPECT_TRUE(std::isfinite(d.q(70, 0)));
  EXPECT_NEAR(d.t[119], 1.19, 1e-12);
}

TEST(Repair, RefusesAGapThatNoLogHas) {
  const std::vector<FindingKind> kinds{FindingKind::kGap};
  for (const double seconds : {1e6, 1e18, 1e300}) {
    std::string said;
    try {
      data::Dataset log = log_with_a_gap(seconds);
      log.source = "import log.csv";
      repair(log, gap(), kinds);
    } catch (const UserError& error) {
      said = error.what();
    }
    EXPECT_THAT(
        said, testing::MatchesRegex("log \\(import log\\.csv\\): [0-9]+ samples of a log after its "
                                    "gaps are filled; allowed: up to 50000000"))
        << seconds;
  }
}

// Stamps that jitter by a seventh of the period, with three samples lost, and forty: no more and no
// less is filled, so that the rows after are where they were.
TEST(Repair, GapsAreToldFromStampsThatAreLateAlone) {
  constexpr int kLength = 20'000;
  Rng rng(1, 0);
  data::Dataset d;
  d.name = "log";
  d.joint_names = {"a"};
  d.rate_hz = 500;
  std::vector<double> t, value;
  for (int k = 0; k < kLength; ++k) {
    if ((k >= 5000 && k < 5003) || (k >= 12'000 && k < 12'040)) continue;
    t.push_back((k + 0.14 * rng.normal()) / d.rate_hz);
    value.push_back(k);
  }
  const auto length = static_cast<Eigen::Index>(t.size());
  d.t = Eigen::VectorXd::Map(t.data(), length);
  d.q = d.tau = Eigen::VectorXd::Map(value.data(), length);
  std::vector<Finding> gaps;
  for (const Finding& f : diagnose(d))
    if (f.kind == FindingKind::kGap) gaps.push_back(f);
  ASSERT_EQ(gaps.size(), 2U);
  EXPECT_EQ(gaps[0].size, 3);
  EXPECT_EQ(gaps[1].size, 40);
  const std::vector<FindingKind> kinds{FindingKind::kGap};
  const data::Dataset filled = repair(d, gaps, kinds);
  ASSERT_EQ(filled.length(), kLength);
  EXPECT_EQ(filled.q(kLength - 1, 0), kLength - 1);
}

// Clocks of every kind of error and size: what a data set may not be, the doctor finds and repairs.
TEST(Repair, FindsAndMendsEveryClockThatTheReaderRefuses) {
  constexpr int kLength = 3000;
  const std::array of_times{FindingKind::kGap, FindingKind::kDuplicate, FindingKind::kOutOfOrder,
                            FindingKind::kJitter, FindingKind::kClockDrift};
  Rng rng(1, 0);
  int refused = 0;
  for (int trial = 0; trial < 400; ++trial) {
    data::Dataset d;
    d.name = "log";
    d.joint_names = {"a"};
    d.rate_hz = 250;
    const double jitter = trial % 5 == 0 ? 0 : std::pow(10, -4 + 3.3 * rng.uniform());
    const double late = trial % 3 == 0 ? 0 : 2 * rng.uniform();  // one stamp, and all after it
    const double drift = trial % 4 == 0 ? 0.02 * rng.uniform() : 0;
    const bool gap = trial % 2 == 0;
    const int rounded = trial % 7 == 0 ? 1 : 0;
    d.t.resize(kLength);
    for (int k = 0; k < kLength; ++k) {
      const bool is_late = gap ? k >= 1000 : k == 1000;
      const double periods =
          k * (1 + drift * k / kLength) + jitter * rng.normal() + (is_late ? late : 0);
      d.t[k] = periods / d.rate_hz;
      if (rounded) d.t[k] = std::round(d.t[k] * 3000) / 3000;
    }
    d.q = d.tau = data::RowMatrix::Random(kLength, 1);
    try {
      data::check_dataset(d, "log");
      continue;
    } catch (const UserError&) {
      ++refused;
    }
    const std::vector<Finding> findings = diagnose(d);
    std::vector<FindingKind> kinds;
    for (const FindingKind kind : of_times)
      if (std::ranges::count(findings, kind, &Finding::kind) > 0) kinds.push_back(kind);
    EXPECT_FALSE(kinds.empty()) << trial << " " << jitter << " " << late << " " << drift;
    EXPECT_NO_THROW(data::check_dataset(repair(d, findings, kinds), "log"))
        << trial << " " << jitter << " " << late << " " << drift;
  }
  EXPECT_GT(refused, 200);
}

// Counters that begin again twice, and once where a sample is lost.
TEST(Repair, LetsACounterThatWrapsGoOn) {
  constexpr double kNanoseconds = 0x1p32 / 1e9, kMicroseconds = 0x1p32 / 1e6;
  const std::vector<FindingKind> kinds{FindingKind::kWrap};
  const auto count = [](const std::vector<Finding>& findings, FindingKind kind) {
    return std::ranges::count(findings, kind, &Finding::kind);
  };
  data::Dataset d = log_with_a_gap(0);
  d.t *= 10;
  d.rate_hz = 10;
  const Eigen::VectorXd whole = d.t;
  for (double& t : d.t) t -= kNanoseconds * std::floor((t + 1) / kNanoseconds);
  std::vector<Finding> findings = diagnose(d);
  EXPECT_EQ(count(findings, FindingKind::kRestart), 0);
  ASSERT_EQ(count(findings, FindingKind::kWrap), 1);
  EXPECT_EQ(findings[0].count, 2);
  EXPECT_LT((repair(d, findings, kinds).t - whole).cwiseAbs().maxCoeff(), 1e-9);

  d = log_with_a_gap(0);
  d.t.tail(30).array() += 0.01 - kMicroseconds;  // a sample is lost, too
  findings = diagnose(d);
  ASSERT_EQ(count(findings, FindingKind::kWrap), 1);
  EXPECT_NEAR(repair(d, findings, kinds).t[99], 1, 1e-9);
  d.t.tail(30).array() += 1;  // no range of a counter
  EXPECT_EQ(count(diagnose(d), FindingKind::kRestart), 1);
}

data::Dataset moving_log(int length) {
  data::Dataset d = log_with_a_gap(0);
  d.joint_names = {"a", "b"};
  d.t = Eigen::VectorXd::LinSpaced(length, 0, (length - 1) / d.rate_hz);
  d.q.resize(length, 2);
  d.q.col(0) = (0.7 * d.t.array()).sin();
  d.q.col(1) = (0.9 * d.t.array() + 1).cos();
  d.tau = d.q;
  return d;
}

void exchange_rows(data::Dataset& d, int i, int k) {
  std::swap(d.t[i], d.t[k]);
  d.q.row(i).swap(d.q.row(k));
  d.tau.row(i).swap(d.tau.row(k));
}

std::vector<std::string> damage_in(const std::vector<Finding>& findings) {
  std::vector<std::string> names;
  for (const Finding& f : findings)
    if (is_damage(f) && f.signal == "t") names.emplace_back(name_of(f.kind));
  return names;
}

// Two threads that write one file: rows are behind later ones, a few of them at either end.
TEST(Repair, SortsRowsThatAreOutOfOrder) {
  using Names = std::vector<std::string>;
  const Names kOutOfOrder{"out_of_order"};
  const data::Dataset whole = moving_log(2000);
  data::Dataset d = whole;
  for (const int k : {0, 40, 41, 300, 900, 1200, 1998}) exchange_rows(d, k, k + 1);
  exchange_rows(d, 500, 503);
  std::vector<Finding> findings = diagnose(d);
  EXPECT_EQ(damage_in(findings), kOutOfOrder);
  const data::Dataset sorted = repair(d, findings, fixes_of(kOutOfOrder));
  EXPECT_EQ(sorted.t, whole.t);
  EXPECT_EQ(sorted.q, whole.q);
  EXPECT_EQ(sorted.tau, whole.tau);
  EXPECT_TRUE(damage_in(diagnose(sorted)).empty());

  // with a row twice, and others lost
  data::Dataset twice = whole;
  for (data::RowMatrix* x : {&twice.q, &twice.tau}) x->row(1000) = x->row(999).eval();
  twice.t[1000] = twice.t[999];
  exchange_rows(twice, 600, 601);
  findings = diagnose(twice);
  EXPECT_EQ(damage_in(findings), (Names{"out_of_order", "gap", "duplicate"}));
  EXPECT_NO_THROW(data::check_dataset(
      repair(twice, findings, fixes_of(Names{"out_of_order", "gap", "duplicate"})), "log"));
  EXPECT_THROW(repair(twice, findings, fixes_of(Names{"gap"})), UserError);
}

// Stamps that are exchanged beside rows in their order, and a stamp that is back, are none of it.
TEST(Repair, DoesNotSortRowsByWrongStamps) {
  const data::Dataset whole = moving_log(2000);
  data::Dataset d = whole;
  for (const int k : {300, 900, 1200}) std::swap(d.t[k], d.t[k + 1]);
  for (const std::string& name : damage_in(diagnose(d))) EXPECT_NE(name, "out_of_order");
  d = whole;
  d.t[700] -= 0.0237;
  for (const std::string& name : damage_in(diagnose(d))) EXPECT_NE(name, "out_of_order");
}

// The seconds of a minute: they begin again while the arm moves on, and once while it stands. Of
// two recordings of a minute each the second begins elsewhere.
TEST(Repair, LetsTheSecondsOfAMinuteGoOn) {
  const std::vector<FindingKind> kinds{FindingKind::kWrap};
  data::Dataset d = moving_log(15000);
  d.q.middleRows(5900, 300).rowwise() = Eigen::RowVectorXd(d.q.row(5900));
  const Eigen::VectorXd whole = d.t;
  for (double& t : d.t) t -= 60 * std::floor((t + 1e-9) / 60);
  const std::vector<Finding> findings = diagnose(d);
  ASSERT_EQ(findings[0].kind, FindingKind::kWrap);
  EXPECT_EQ(findings[0].count, 2);
  EXPECT_LT((repair(d, findings, kinds).t - whole).cwiseAbs().maxCoeff(), 1e-9);

  data::Dataset two = moving_log(12000);
  two.t.tail(6000) = two.t.head(6000).eval();
  two.q.bottomRows(6000) = two.q.topRows(6000).eval();
  EXPECT_EQ(diagnose(two)[0].kind, FindingKind::kRestart);
}

// Rows lost where the time counts rows: what is left lies at the times at which it was taken, but
// for what is lost where nothing moves.
TEST(Repair, LetsTheTimeRunOnWhereRowsAreLost) {
  const data::Dataset whole = moving_log(3000);
  data::Dataset d = whole;
  std::vector<int> rows;
  for (int k = 0; k < whole.length(); ++k)
    if (k % 97 != 96 && (k < 1000 || k > 1002)) rows.push_back(k);
  d.q = data::RowMatrix(whole.q(rows, Eigen::all));
  d.tau = data::RowMatrix(whole.tau(rows, Eigen::all));
  d.t = Eigen::VectorXd(whole.t.head(std::ssize(rows)));
  const std::vector<Finding> findings = diagnose(d);
  ASSERT_EQ(std::ranges::count(findings, FindingKind::kLost, &Finding::kind), 1);
  const std::vector<FindingKind> kinds{FindingKind::kLost};
  const data::Dataset repaired = repair(d, findings, kinds);
  // where both joints turn round nothing shows, and less is lost
  const int lost = whole.length() - d.length(), found = repaired.length() - d.length();
  EXPECT_LE(found, lost);
  EXPECT_GE(found, lost - 3);
  int next = 0;
  for (int k = 0; k < repaired.length(); ++k) {
    if (!std::isfinite(repaired.q(k, 0))) continue;
    EXPECT_LE(std::abs(k - rows[static_cast<std::size_t>(next)]), lost - found) << k;
    EXPECT_EQ(repaired.q(k, 0), d.q(next++, 0));
  }
  EXPECT_EQ(next, d.length());
}

// A gap that is not to be filled is not closed up either.
TEST(Repair, EvenTimesKeepGapsAndRepeatedRows) {
  data::Dataset d = log_with_a_gap(0.2);
  Rng rng(1, 0);
  for (int k = 0; k < d.length(); ++k) d.t[k] += 4e-4 * rng.normal();
  d.t[20] = d.t[19];  // in place of its own
  const std::vector<Finding> jitter{{.kind = FindingKind::kJitter, .signal = "t"}};
  const std::vector<FindingKind> kinds{FindingKind::kJitter};
  const data::Dataset even = repair(d, jitter, kinds);
  EXPECT_NEAR(even.t[19], 0.19, 1e-12);
  EXPECT_NEAR(even.t[20], 0.19, 1e-12);
  EXPECT_NEAR(even.t[49], 0.49, 1e-12);
  EXPECT_NEAR(even.t[50], 0.7, 1e-12);
}

// Samples taken late, at the times that are logged: interpolated, they are those of even times.
TEST(Repair, InterpolatesSamplesThatWereTakenUnevenly) {
  constexpr int kLength = 3000;
  data::Dataset d;
  d.name = "log";
  d.joint_names = {"a"};
  d.rate_hz = 100;
  d.t.resize(kLength);
  d.q.resize(kLength, 1);
  d.tau.resize(kLength, 1);
  Rng rng(8, 0);
  for (int k = 0; k < kLength; ++k) {
    const double t = 0.01 * k + 4e-3 * rng.uniform();
    d.t[k] = t;
    d.q(k, 0) = std::sin(2 * t) + 1e-5 * rng.normal();
    d.tau(k, 0) = std::cos(2 * t) + 0.01 * rng.normal();
  }
  const std::vector<Finding> findings = diagnose(d);
  const auto names = [&](FindingKind kind) {
    return std::ranges::count(findings, kind, &Finding::kind);
  };
  EXPECT_EQ(names(FindingKind::kUneven), 1);
  EXPECT_EQ(
      names(FindingKind::kJitter) + names(FindingKind::kGap) + names(FindingKind::kClockDrift), 0);
  const data::Dataset even = repair(d, findings, {{FindingKind::kUneven}});
  EXPECT_THAT(even.source, testing::HasSubstr("fixed uneven"));
  for (int k = 0; k < even.length(); ++k)
    EXPECT_NEAR(even.q(k, 0), std::sin(2 * even.t[k]), 8e-5) << k;
}

// The reader evens slight jitter out: a script that names it goes on.
TEST(Repair, JitterMayBeNamedWhereThereIsNone) {
  const std::vector<FindingKind> jitter{FindingKind::kJitter}, gap{FindingKind::kGap};
  const data::Dataset d = log_with_a_gap(0);
  EXPECT_EQ(repair(d, {}, jitter).source, d.source);
  EXPECT_THROW(repair(d, {}, gap), UserError);
}

TEST(Repair, TakesWholeTurnsOutAndNoOtherJump) {
  const std::vector<FindingKind> kinds{FindingKind::kJump};
  for (const double turns : {1.0, -2.0}) {
    data::Dataset d = log_with_a_gap(0);
    const data::RowMatrix q = d.q;
    d.q.bottomRows(40).array() += 2 * std::numbers::pi * turns;
    const std::vector<Finding> jump{{.kind = FindingKind::kJump,
                                     .signal = "q",
                                     .joint = 0,
                                     .size = d.q(60, 0) - q(60, 0) + 0.05,
                                     .rows = {60}}};
    EXPECT_LT((repair(d, jump, kinds).q - q).cwiseAbs().maxCoeff(), 1e-12);
  }
  for (const double size : {-0.5895, 3.5}) {
    const std::vector<Finding> jump{
        {.kind = FindingKind::kJump, .signal = "q", .joint = 0, .size = size, .rows = {60}}};
    EXPECT_THROW(repair(log_with_a_gap(0), jump, kinds), UserError) << size;
  }
}

TEST(DiagnosisFile, HoldsWhatWasFoundAndWhatToDo) {
  data::Dataset d = log_with_a_gap(0.2);
  d.joint_names = {"a", "b"};
  d.source = "a test";
  const std::vector<Finding> findings{
      {.kind = FindingKind::kGap,
       .signal = "t",
       .begin_s = 0.5,
       .end_s = 0.7,
       .size = 20,
       .unit = "samples"},
      {.kind = FindingKind::kSwapped, .signal = "q tau", .joint = 1, .other = 0, .count = 2},
      {.kind = FindingKind::kRate, .signal = "t"}};
  const data::DiagnosisFile file = diagnosis_file(findings, d);
  EXPECT_EQ(file.data, "log");
  EXPECT_EQ(file.source, "a test");
  EXPECT_EQ(file.joints, d.joint_names);
  ASSERT_EQ(file.findings.size(), 3U);
  EXPECT_EQ(file.findings[0].severity, data::Severity::kDamage);
  EXPECT_TRUE(file.findings[0].joints.empty());
  EXPECT_EQ(file.findings[0].size, 20);
  EXPECT_EQ(file.findings[0].remedy, info_of(FindingKind::kGap).remedy);
  EXPECT_TRUE(file.findings[1].misleads);
  EXPECT_EQ(file.findings[1].joints, (std::vector<std::string>{"b", "a"}));
  EXPECT_EQ(file.findings[1].count, 2);
  EXPECT_EQ(file.findings[2].severity, data::Severity::kNote);
}

// Rows that are held three times: what is left is the source's log.
TEST(Repair, KeepsTheRowsOfASlowerSource) {
  constexpr int kHeld = 3, kLength = 600;
  data::Dataset source = log_with_a_gap(0);
  source.t = Eigen::VectorXd::LinSpaced(kLength, 0, (kLength - 1) * 0.03);
  source.q.resize(kLength, 1);
  source.tau.resize(kLength, 1);
  for (int k = 0; k < kLength; ++k) {
    source.q(k, 0) = std::sin(0.9 * source.t[k]);
    source.tau(k, 0) = std::cos(0.7 * source.t[k]);
  }
  source.rate_hz = 100. / kHeld;
  data::Dataset held = source;
  held.rate_hz = 100;
  held.t = Eigen::VectorXd::LinSpaced(kHeld * kLength, 0, (kHeld * kLength - 1) * 0.01);
  held.q.resize(kHeld * kLength, 1);
  held.tau.resize(kHeld * kLength, 1);
  for (int k = 0; k < held.length(); ++k) {
    held.q.row(k) = source.q.row(k / kHeld);
    held.tau.row(k) = source.tau.row(k / kHeld);
  }
  const std::vector<Finding> findings = diagnose(held);
  ASSERT_TRUE(std::ranges::count(findings, FindingKind::kHeld, &Finding::kind) == 1);
  const data::Dataset repaired = repair(held, findings, {{FindingKind::kHeld}});
  EXPECT_NEAR(repaired.rate_hz, source.rate_hz, 1e-9);
  ASSERT_EQ(repaired.length(), kLength);
  EXPECT_EQ(repaired.q, source.q);
  EXPECT_EQ(repaired.tau, source.tau);
  EXPECT_TRUE(repaired.t.isApprox(source.t));

  // what else is found is of the log without these rows
  std::vector<Finding> more = findings;
  more.push_back({.kind = FindingKind::kSpike, .signal = "q", .joint = 0, .rows = {5}});
  EXPECT_THROW(repair(held, more, {{FindingKind::kSpike}}), UserError);
  const std::vector<FindingKind> both{FindingKind::kSpike, FindingKind::kHeld};
  EXPECT_TRUE(std::isnan(repair(held, more, both).q(5, 0)));
}

}  // namespace
}  // namespace fricid::doctor
