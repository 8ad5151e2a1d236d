#include "fricid/data/log_part.hpp"

#include <cmath>
#include <limits>

#include <fmt/format.h>

#include "fricid/base/rng.hpp"
#include "fricid/data/training_part.hpp"
#include "scene_folder.hpp"

namespace fricid::data {
namespace {

class LogPartTest : public FolderTest {};

TEST_F(LogPartTest, ReadsAFileAndSecondsOfIt) {
  EXPECT_EQ(log_part("a/b.csv").file, "a/b.csv");
  EXPECT_EQ(log_part("a/b.csv").from_s, 0);
  EXPECT_EQ(log_part("a/b.csv").to_s, std::numeric_limits<double>::infinity());
  const LogPart both = log_part("b.csv[1.5:20]");
  EXPECT_EQ(both.file, "b.csv");
  EXPECT_EQ(both.from_s, 1.5);
  EXPECT_EQ(both.to_s, 20);
  EXPECT_EQ(log_part("b.csv[:20]").from_s, 0);
  EXPECT_EQ(log_part("b.csv[7:]").from_s, 7);
  EXPECT_TRUE(log_part("b[:20]").overlaps(log_part("b[19:]")));
  EXPECT_FALSE(log_part("b[:20]").overlaps(log_part("b[20:]")));
  EXPECT_TRUE(log_part("b").overlaps(log_part("b[20:]")));
}

TEST_F(LogPartTest, RefusesWhatIsNoPart) {
  for (const char* text : {"b.csv[20:10]", "b.csv[x:10]", "b.csv[10]", "b.csv[-1:2]", "b.csv[1:1]"})
    EXPECT_EQ(message_of([&] { log_part(text); }),
              std::string(text) + ": " + std::string(text).substr(5) +
                  " is no part of a log; allowed: seconds [FROM:TO], FROM below TO");
}

Dataset ten_samples() {
  Dataset d;
  d.joint_names = {"a", "b", "c"};
  d.rate_hz = 10;
  d.t = Eigen::VectorXd::LinSpaced(10, 5, 5.9);
  d.q = RowMatrix::Zero(10, 3);
  for (int k = 0; k < 10; ++k)
    for (int j = 0; j < 3; ++j) d.q(k, j) = 10 * k + j;
  d.tau = -d.q;
  return d;
}

TEST_F(LogPartTest, PartsOfALogHaveNoSampleInCommonAndNoneIsLost) {
  const Dataset d = ten_samples();
  const Dataset first = cut(d, log_part("x[:0.4]"), "x"), rest = cut(d, log_part("x[0.4:]"), "x");
  EXPECT_EQ(first.length(), 4);
  EXPECT_EQ(rest.length(), 6);
  EXPECT_EQ(rest.q(0, 1), 41);
  EXPECT_EQ(rest.tau(5, 2), -92);
  EXPECT_EQ(cut(d, log_part("x"), "x").length(), 10);
  EXPECT_EQ(message_of([&] { cut(d, log_part("x[7:]"), "x"); }),
            "x: 0 samples from 7 to inf s; the log has 0.9 s");
  EXPECT_EQ(message_of([&] { cut(d, log_part("x[0.4:2]"), "x"); }),
            "x: a part that ends at 2 s; the log has 1 s");
}

TEST_F(LogPartTest, WeldedJointsLeaveALogThatHasThemAtRest) {
  Dataset d = ten_samples();
  d.q.col(1).setConstant(0.3);
  d.q(4, 1) = 0.31;
  const Dataset rest = of_joints(d, {"a", "c"}, {{"b", 0.3}, {"z", 9}}, "x");
  EXPECT_EQ(rest.joint_names, (std::vector<std::string>{"a", "c"}));
  EXPECT_EQ(rest.q(3, 1), 32);
  EXPECT_EQ(rest.tau(5, 1), -52);
  EXPECT_EQ(rest.v.size(), 0);
  d.q(7, 1) = 0.35;
  EXPECT_EQ(message_of([&] {
              of_joints(d, {"a", "c"}, {{"b", 0.3}}, "x");
            }),
            "x: b is welded at 0.3 and here at 0.35; allowed: within 0.02 rad or m; use a part of "
            "the log where it rests (\"x[FROM:TO]\"), or let it move");
}

// A data set keeps the order of its contract; a robot has its own.
TEST_F(LogPartTest, JointsAreTakenByName) {
  const Dataset d = ten_samples();
  const Dataset other = of_joints(d, {"c", "a", "b"}, {}, "x");
  EXPECT_EQ(other.joint_names, (std::vector<std::string>{"c", "a", "b"}));
  EXPECT_EQ(other.q.col(0), d.q.col(2));
  EXPECT_EQ(other.tau.col(1), d.tau.col(0));
  EXPECT_EQ(message_of([&] {
              of_joints(d, {"a", "elbow"}, {}, "x");
            }),
            "x: joints a b c; elbow of the robot is not logged: allowed: all that move; where it "
            "rests, fix = {elbow = POSITION} in [robot] of a scene, or type=\"fixed\" in the URDF");
}

/// Two joints that swing, at 100 Hz.
Dataset swinging(const std::string& name, int samples) {
  Dataset d;
  d.name = name;
  d.joint_names = {"a", "b"};
  d.rate_hz = 100;
  d.t = Eigen::VectorXd::LinSpaced(samples, 0, (samples - 1) / 100.);
  d.q.resize(samples, 2);
  for (int k = 0; k < samples; ++k) d.q.row(k) << std::sin(0.02 * k), std::cos(0.01 * k);
  d.tau = 3 * d.q;
  return d;
}

TEST(SamplesInCommon, AreFoundWhereverTheyBegin) {
  const Dataset whole = swinging("a", 1000);
  EXPECT_EQ(samples_in_common(whole, whole), 1000);
  EXPECT_EQ(samples_in_common(rows_of(whole, 300, 200), whole), 200);
  EXPECT_EQ(samples_in_common(whole, rows_of(whole, 300, 200)), 200);
  Dataset later = rows_of(whole, 300, 200);
  later.t.array() += 7;
  EXPECT_EQ(samples_in_common(later, whole), 200);
  EXPECT_EQ(samples_in_common(rows_of(whole, 0, 500), rows_of(whole, 500, 500)), 0);
}

// Two logs of a robot at rest are not the same log, nor are two with one sample that is alike.
TEST(SamplesInCommon, AreThoseOfMotion) {
  Dataset rest = swinging("a", 100), other = swinging("b", 100);
  rest.q.setConstant(0.5);
  rest.tau.setConstant(1);
  EXPECT_EQ(samples_in_common(rest, rest), 0);
  other.tau.array() += 1e-3;
  other.tau.row(50) = swinging("a", 100).tau.row(50);
  EXPECT_EQ(samples_in_common(other, swinging("a", 100)), 0);
  Dataset missing = swinging("a", 100);
  missing.q.row(20).setConstant(std::numeric_limits<double>::quiet_NaN());
  EXPECT_EQ(samples_in_common(missing, missing), 100);
}

/// A robot that repeats a motion at 1 kHz, each time with noise of its own, read by sensors with
/// these steps; 0: none.
Dataset measured(std::uint64_t seed, double position_step, double torque_step) {
  constexpr int kSamples = 4000;
  constexpr double kPositionNoise = 4e-6, kTorqueNoise = 0.02;
  Rng rng(seed, 0);
  Dataset d = swinging("a", kSamples);
  d.rate_hz = 1000;
  d.t = Eigen::VectorXd::LinSpaced(kSamples, 0, (kSamples - 1) / d.rate_hz);
  for (int k = 0; k < kSamples; ++k)
    for (int j = 0; j < 2; ++j) {
      const double w = 3. + j, v = std::cos(w * d.t[k]);
      d.q(k, j) = std::sin(w * d.t[k]) + kPositionNoise * rng.normal();
      d.tau(k, j) = 20 * d.q(k, j) + (v > 0 ? 5 : -5) + 2 * v + kTorqueNoise * rng.normal();
    }
  const auto read = [](RowMatrix& x, double step) {
    if (step > 0) x = (x.array() / step).round() * step;
  };
  read(d.q, position_step);
  read(d.tau, torque_step);
  return d;
}

Dataset rounded(Dataset d, double position_step, double torque_step) {
  d.q = (d.q.array() / position_step).round() * position_step;
  d.tau = (d.tau.array() / torque_step).round() * torque_step;
  return d;
}

// Exported once more with fewer digits, from another sample on.
TEST(SamplesInCommon, AreFoundThroughRounding) {
  for (const double torque_step : {0., 0.005, 0.1}) {
    const Dataset whole = measured(1, 1e-5, torque_step), part = rows_of(whole, 1200, 2000);
    const auto expect_found = [&](const Dataset& exported, const char* how) {
      SCOPED_TRACE(fmt::format("{}, torque in steps of {}", how, torque_step));
      EXPECT_GE(samples_in_common(exported, whole), 1900);
      EXPECT_GE(samples_in_common(whole, exported), 1900);
      EXPECT_GE(samples_in_common(exported, rounded(whole, 1e-9, 1e-9)), 1900);
    };
    expect_found(rounded(part, 1e-6, 1e-6), "six decimals");
    expect_found(rounded(part, 1e-4, 1e-2), "four and two decimals");
    expect_found(rounded(part, 1e-4, 0.1), "four decimals and one");
    Dataset single = part;
    single.q = part.q.cast<float>().cast<double>();
    single.tau = part.tau.cast<float>().cast<double>();
    expect_found(single, "float");
    Dataset degrees = part;  // read back from degrees of four decimals
    degrees.q = (part.q.array() * 57.29577951308232 * 1e4).round() / 1e4 / 57.29577951308232;
    expect_found(degrees, "degrees of four decimals");
  }
}

TEST(SamplesInCommon, AreNotThoseOfAMotionThatIsRepeated) {
  for (const double torque_step : {0., 0.005, 0.02, 0.1}) {
    const Dataset first = measured(1, 1e-5, torque_step), second = measured(2, 1e-5, torque_step);
    SCOPED_TRACE(fmt::format("torque in steps of {}", torque_step));
    EXPECT_EQ(samples_in_common(first, second), 0);
    EXPECT_EQ(samples_in_common(first, rounded(second, 1e-4, 0.1)), 0);
    EXPECT_EQ(samples_in_common(rounded(first, 1e-4, 0.1), rounded(second, 1e-4, 0.1)), 0);
    EXPECT_EQ(samples_in_common(rounded(first, 1e-6, 1e-6), second), 0);
  }
}

TEST(TrainingPart, IsAllOfWhatIsShort) {
  const std::vector<Dataset> logs{swinging("a", 1000), swinging("b", 600)};
  const TrainingPart part = training_part(logs, 1600);
  EXPECT_TRUE(part.is_all());
  ASSERT_EQ(part.recordings.size(), 2u);
  EXPECT_EQ(part.recordings[1].name, "b");
  EXPECT_EQ(part.recordings[1].q, logs[1].q);
}

// An hour in two recordings: pieces from every part of it, no more samples than allowed.
TEST(TrainingPart, OfALongCampaignIsDrawnOverAllOfIt) {
  const std::vector<Dataset> logs{swinging("a", 240'000), swinging("b", 120'000)};
  const TrainingPart part = training_part(logs, 32'000);
  EXPECT_FALSE(part.is_all());
  EXPECT_EQ(part.of_seconds, 3600);
  EXPECT_EQ(part.seconds, 320);
  ASSERT_EQ(part.recordings.size(), 16u);
  const TrainingPart again = training_part(logs, 32'000);
  double last = -1;
  for (std::size_t i = 0; i < part.recordings.size(); ++i) {
    const Dataset& piece = part.recordings[i];
    SCOPED_TRACE(piece.name);
    EXPECT_EQ(piece.name, again.recordings[i].name);
    EXPECT_EQ(piece.length(), 2000);
    const Dataset& of = piece.name[0] == 'a' ? logs[0] : logs[1];
    const auto first = static_cast<Eigen::Index>(std::lround(100 * piece.t[0]));
    EXPECT_EQ(piece.q, of.q.middleRows(first, 2000));
    EXPECT_EQ(piece.name, fmt::format("{}[{:g}:{:g}]", of.name, piece.t[0], piece.t[0] + 20));
    // one in each sixteenth of the hour, in order
    const double at = piece.t[0] + (piece.name[0] == 'b' ? 2400 : 0);
    EXPECT_GE(at, 225. * static_cast<double>(i) - 20);
    EXPECT_LE(at, 225. * static_cast<double>(i + 1));
    EXPECT_GT(at, last);
    last = at;
  }
}

TEST(TrainingPart, PausesAreNoPartOfIt) {
  Dataset d = swinging("a", 100'000);
  d.q.middleRows(20'000, 30'000).rowwise() = d.q.row(20'000).eval();
  d.tau.middleRows(60'000, 30'000).setConstant(std::numeric_limits<double>::quiet_NaN());
  const TrainingPart part = training_part(std::vector{d}, 16'000);
  EXPECT_EQ(part.seconds, 160);
  for (const Dataset& piece : part.recordings) {
    SCOPED_TRACE(piece.name);
    EXPECT_TRUE(piece.tau.allFinite());
    EXPECT_GT(piece.q.col(0).maxCoeff() - piece.q.col(0).minCoeff(), 0.1);
  }
}

}  // namespace
}  // namespace fricid::data
