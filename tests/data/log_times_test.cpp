// Rates and even times, of the time stamps of a log.
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "fricid/base/rng.hpp"
#include "fricid/data/uneven_times.hpp"
#include "import_fixture.hpp"

namespace fricid::data {
namespace {

using testing::ElementsAre;

// Stamps in whole milliseconds: 3, 3, 4, 3, 3, 4 ms are 300 Hz, also where samples are lost.
TEST_F(Import, TheRateIsNotThatOfOneRoundedPeriod) {
  for (const double rate : {60.0, 128.0, 300.0})
    for (const bool gaps : {false, true}) {
      std::string log = "t,q1,q2,tau1,tau2\n";
      for (int k = 0; k < 6000; ++k)
        if (!gaps || k % 500 > 7)
          log += fmt::format("{},{},0,0,1\n", 1e-3 * std::floor(1e3 * k / rate), k);
      const Dataset d = read_log(write("log.csv", log), contract());
      EXPECT_NEAR(d.rate_hz, rate, 1e-3 * rate) << rate << " " << gaps;
    }
}

// Stamps that are late by up to the period, some of which look like gaps; with samples lost, too.
TEST_F(Import, LateStampsDoNotChangeTheRate) {
  for (const bool gaps : {false, true}) {
    Rng rng(1, 0);
    std::string log = "t,q1,q2,tau1,tau2\n";
    for (int k = 0; k < 15'000; ++k) {
      const double late = std::min(4e-3, std::abs(1e-3 * rng.normal()));
      if (!gaps || k % 3000 > 40) log += fmt::format("{:.7f},{},0,0,1\n", 0.004 * k + late, k);
    }
    EXPECT_NEAR(read_log(write("log.csv", log), contract()).rate_hz, 250, gaps ? 2e-2 : 2e-3);
  }
}

// Stamps of 4 ms samples in whole steps of 10 ms or 5 ms, rounded or cut off.
TEST_F(Import, TimesInStepsCoarserThanTheSamplesAreMadeEven) {
  using Whole = double (*)(double);
  const auto log_of = [](double step, Whole to_whole, int lost) {
    std::string log = "t,q1,q2,tau1,tau2\n";
    for (int k = 0; k < 6000; ++k)
      if (k < 3000 || k >= 3000 + lost)
        log += fmt::format("{:.4f},{},0,{},1\n", step * to_whole(0.004 * k / step + 1e-9), k, k);
    return log;
  };
  for (const double step : {5e-3, 1e-2})
    for (const Whole to_whole : {Whole{std::floor}, Whole{std::round}}) {
      std::vector<std::string> warnings;
      const Dataset d = import_log(write("log.csv", log_of(step, to_whole, 0)), contract(),
                                   [&](const std::string& line) { warnings.push_back(line); });
      EXPECT_NEAR(d.rate_hz, 250, 1e-3);
      EXPECT_NEAR(d.t[5999], 0.004 * 5999, 1e-4);
      EXPECT_EQ(d.q(5999, 0), 5999);
      EXPECT_THAT(d.source, testing::HasSubstr("made even"));
      EXPECT_THAT(warnings, ElementsAre(testing::HasSubstr("coarser than the samples")));
      EXPECT_THAT(log_error(log_of(step, to_whole, 50)),
                  testing::AllOf(testing::HasSubstr("coarser than the samples"),
                                 testing::HasSubstr("a time with more digits")));
    }
}

// Stamps of whole seconds, or of ten: a row with a new stamp was taken within a sample of it.
TEST_F(Import, AFewCoarseTimesTellTheRateOrAreRefused) {
  const auto log_of = [](double step, double begin, int rows) {
    std::string log = "t,q1,q2,tau1,tau2\n";
    for (int k = 0; k < rows; ++k)
      log += fmt::format("{:.0f},{},0,{},1\n", step * std::floor((begin + 0.004 * k) / step), k, k);
    return log;
  };
  EXPECT_NEAR(import(log_of(1, 0.3, 1100)).rate_hz, 250, 0.5);
  EXPECT_NEAR(import(log_of(10, 3, 5000)).rate_hz, 250, 0.1);
  EXPECT_THAT(log_error(log_of(10, 3, 3000)),
              testing::HasSubstr("most rows have the time of the one before"));
}

// A row that is written twice has one time and is no sample of its own.
TEST_F(Import, RowsWrittenTwiceAreNoCoarseTimes) {
  std::string log = "t,q1,q2,tau1,tau2\n";
  for (int k = 0; k < 2000; ++k)
    for (int i = 0; i < (k % 3 == 0 ? 2 : 1); ++i)
      log += fmt::format("{:.3f},{},0,0,1\n", 0.004 * k, k);
  const Dataset d = read_log(write("log.csv", log), contract());
  EXPECT_NEAR(d.rate_hz, 250, 1e-6);
  EXPECT_EQ(d.t[1], 0);
  // all of them, as where two programs publish one state
  std::string twice = "t,q1,q2,tau1,tau2\n";
  for (int k = 0; k < 4000; ++k) twice += fmt::format("{:.3f},{},0,0,1\n", 0.004 * (k / 2), k / 2);
  EXPECT_NEAR(read_log(write("log.csv", twice), contract()).rate_hz, 250, 1e-6);
}

// Samples that are taken in time and stamped late by 20 us or so of 4 ms, as in bags of ROS.
TEST_F(Import, SlightJitterIsEvenedOut) {
  const auto log_of = [](double sd, double late) {
    Rng rng(1, 0);
    std::string log = "t,q1,q2,tau1,tau2\n";
    for (int k = 0; k < 2000; ++k)
      log += fmt::format("{:.7f},{},0,0,1\n", 0.004 * k + sd * rng.normal() + (k == 700 ? late : 0),
                         k % 3);
    return log;
  };
  for (const double sd : {13e-6, 40e-6, 80e-6}) {
    std::vector<std::string> warnings;
    const Dataset d = import_log(write("log.csv", log_of(sd, 3e-4)), contract(),
                                 [&](const std::string& warning) { warnings.push_back(warning); });
    EXPECT_NEAR(d.rate_hz, 250, 0.02);
    EXPECT_LT((d.t.array() * d.rate_hz - Eigen::ArrayXd::LinSpaced(2000, 0, 1999)).abs().maxCoeff(),
              1e-9);
    EXPECT_THAT(d.source, testing::HasSubstr("made even")) << sd;
    EXPECT_THAT(warnings, ElementsAre(testing::HasSubstr("samples are taken as even"))) << sd;
    EXPECT_EQ(d.q(701, 0), 701 % 3);
  }
  EXPECT_THAT(import(log_of(0, 0)).source, testing::Not(testing::HasSubstr("even")));
  for (const auto& [sd, late] : {std::pair(200e-6, 0.0), std::pair(0.0, 1e-3)})
    EXPECT_THAT(log_error(log_of(sd, late)), testing::HasSubstr("jitter in time")) << sd;
}

// Two joints that move, sampled at given times; `stamps` are what the log says of these.
Dataset motion_at(const Eigen::VectorXd& times, const Eigen::VectorXd& stamps, double rate_hz) {
  Dataset d;
  d.name = "log";
  d.joint_names = {"a", "b"};
  d.rate_hz = rate_hz;
  d.t = stamps;
  d.q.resize(times.size(), 2);
  d.tau.resize(times.size(), 2);
  Rng rng(4, 0);
  for (Eigen::Index k = 0; k < times.size(); ++k) {
    d.q.row(k) << std::sin(2 * times[k]), 0.5 * std::cos(3.1 * times[k]);
    for (double& q : d.q.row(k)) q += 2e-5 * rng.normal();
    d.tau.row(k) << times[k], 1 - 2 * times[k];
  }
  return d;
}

// A loop that sleeps between samples takes them at its stamps; one that a controller feeds takes
// them evenly and stamps them late. The motion tells which, jitter below its noise does not.
TEST(UnevenTimes, TheMotionTellsWhenSamplesWereTaken) {
  constexpr double kRate = 100;
  for (const double late : {2e-4, 2e-3, 1e-8}) {
    Rng rng(3, 0);
    Eigen::VectorXd even = Eigen::VectorXd::LinSpaced(2000, 0, 1999) / kRate, stamps = even;
    for (double& t : stamps) t += late * rng.uniform();
    const bool shows = late > 1e-6;
    EXPECT_EQ(taken(motion_at(stamps, stamps, kRate)), shows ? Taken::kAtStamps : Taken::kNotTold);
    EXPECT_EQ(taken(motion_at(even, stamps, kRate)), shows ? Taken::kEvenly : Taken::kNotTold);
    // samples that are lost tell nothing
    Eigen::VectorXd fewer(1900);
    for (Eigen::Index k = 0; k < fewer.size(); ++k) fewer[k] = even[k + k / 19];
    EXPECT_EQ(taken(motion_at(fewer, fewer, kRate)), Taken::kNotTold);
  }
}

TEST(UnevenTimes, AreInterpolatedAtEvenOnes) {
  constexpr double kRate = 100;
  Rng rng(5, 0);
  Eigen::VectorXd stamps = Eigen::VectorXd::LinSpaced(800, 0, 799) / kRate;
  for (double& t : stamps.tail(799)) t += 6e-3 * rng.uniform();
  stamps.tail(400).array() += 0.1;  // a pause
  Dataset d = motion_at(stamps, stamps, kRate);
  const auto cubic = [](double t) { return 1 - 2 * t + 0.3 * t * t - 0.02 * t * t * t; };
  for (Eigen::Index k = 0; k < stamps.size(); ++k) d.q(k, 0) = cubic(stamps[k]);
  d.t[200] = d.t[199];  // a row that is there twice
  const Dataset even = at_even_times(d);
  EXPECT_EQ(even.rate_hz, kRate);
  EXPECT_EQ(even.length(), static_cast<int>(std::floor(stamps[799] * kRate)) + 1);
  int missing = 0;
  for (int k = 0; k < even.length(); ++k) {
    EXPECT_NEAR(even.t[k], k / kRate, 1e-12);
    if (std::isnan(even.q(k, 0))) {
      ++missing;
      EXPECT_GT(even.t[k], stamps[399]);
      EXPECT_LT(even.t[k], stamps[400]);
      continue;
    }
    EXPECT_NEAR(even.q(k, 0), cubic(even.t[k]), 1e-9);
    EXPECT_NEAR(even.q(k, 1), 0.5 * std::cos(3.1 * even.t[k]), 3e-4);
    EXPECT_NEAR(even.tau(k, 1), 1 - 2 * even.t[k], 1e-9);
  }
  EXPECT_GE(missing, 9);
  d.t.setZero();
  EXPECT_THROW(at_even_times(d), UserError);
}

// Slight unevenness of samples that were taken at their stamps is interpolated by the reader.
TEST_F(Import, SlightUnevennessIsInterpolated) {
  Rng rng(6, 0);
  std::string log = "t,q1,q2,tau1,tau2\n";
  for (int k = 0; k < 2000; ++k) {
    const double t = 0.01 * k + 5e-4 * rng.uniform();
    log += fmt::format("{:.7f},{:.6f},{:.6f},{:.6f},1\n", t, std::sin(2 * t), std::cos(3 * t), t);
  }
  std::vector<std::string> warnings;
  const Dataset d = import_log(write("log.csv", log), contract(),
                               [&](const std::string& warning) { warnings.push_back(warning); });
  EXPECT_THAT(d.source, testing::HasSubstr("interpolated"));
  EXPECT_THAT(warnings, ElementsAre(testing::HasSubstr("smooth by the stamps")));
  const double begin = std::stod(log.substr(log.find('\n') + 1));
  for (int k = 0; k < d.length(); ++k)
    EXPECT_NEAR(d.q(k, 0), std::sin(2 * (begin + k / d.rate_hz)), 1e-5) << k;
}

}  // namespace
}  // namespace fricid::data
