#include "fricid/data/log_part.hpp"

#include <limits>

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

}  // namespace
}  // namespace fricid::data
