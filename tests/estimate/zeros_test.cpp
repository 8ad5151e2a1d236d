// Logs whose joints have another zero are told apart from logs that differ otherwise.
#include <gmock/gmock.h>

#include <fmt/ranges.h>

#include <span>
#include <string>
#include <tuple>
#include <vector>

#include "arm_data.hpp"
#include "fricid/estimate/rigid_body/held_out.hpp"
#include "fricid/estimate/rigid_body/identifiability.hpp"

namespace fricid::estimate {
namespace {

using testing::ContainsRegex;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;

constexpr int kCount = 4;

std::vector<data::Dataset> make_logs(const Arm& arm) {
  std::vector<data::Dataset> logs;
  for (std::uint64_t seed = 1; seed <= kCount; ++seed)
    logs.push_back(make_log(arm, {.seconds = 24, .torque_noise = 0.1, .seed = seed}));
  return logs;
}

std::string doubts_of(const dynamics::RobotModel& robot, const std::vector<data::Dataset>& logs) {
  std::vector<signals::Recording> recordings;
  for (const data::Dataset& log : logs) recordings.push_back(signals::make_recording(log, 10));
  return fmt::format("{}", fmt::join(examine_data(robot, recordings, {}).doubts, "\n"));
}

const Arm& arm() {
  static const Arm kArm = coulomb_arm(5e-3);
  return kArm;
}

const std::vector<data::Dataset>& clean() {
  static const std::vector<data::Dataset> kLogs = make_logs(arm());
  return kLogs;
}

TEST(Zeros, OneInAllLogsIsNoFault) { EXPECT_THAT(doubts_of(arm().robot, clean()), IsEmpty()); }

// Of one log, and of half of them, which is told as the half that is further.
TEST(Zeros, AnotherOneIsFoundWithItsSize) {
  for (const auto& [joint, by, moved] :
       {std::tuple{1, 0.02, std::vector{2}}, {2, -0.1, {1}}, {1, 0.02, {0, 3}}}) {
    std::vector<data::Dataset> logs = clean();
    for (const int log : moved) logs[static_cast<std::size_t>(log)].q.col(joint).array() += by;
    const std::string doubts = doubts_of(arm().robot, logs);
    EXPECT_THAT(doubts, HasSubstr(arm().robot.joints[static_cast<std::size_t>(joint)].name +
                                  ": its zero is another one"));
    for (const int log : moved) {
      const std::string name = logs[static_cast<std::size_t>(log)].name + " by ";
      const std::size_t at = doubts.find(name);
      ASSERT_NE(at, std::string::npos) << doubts;
      EXPECT_NEAR(std::stod(doubts.substr(at + name.size())), by, 0.1 * std::abs(by)) << doubts;
    }
  }
}

// A log in which the arm hardly moves says nothing of zeros.
TEST(Zeros, OfALogThatDoesNotKnowThemAreNotNamed) {
  std::vector<data::Dataset> logs = clean();
  logs[1].q.col(1).array() += 0.05;
  LogOptions first_alone{.seconds = 24, .torque_noise = 0.1, .seed = 9};
  first_alone.moving = 0;
  logs.push_back(make_log(arm(), first_alone));
  const std::string doubts = doubts_of(arm().robot, logs);
  EXPECT_THAT(doubts, HasSubstr("seed_2 by 0.0"));
  EXPECT_THAT(doubts, Not(HasSubstr("seed_9")));
}

// About a vertical first axis nothing changes with its position.
TEST(Zeros, OfAVerticalAxisSaysNothing) {
  std::vector<data::Dataset> logs = clean();
  logs[1].q.col(0).array() += 0.3;
  EXPECT_THAT(doubts_of(arm().robot, logs), IsEmpty());
}

TEST(Zeros, AreNotWhatALoadOrAnOffsetChanges) {
  Arm loaded = arm();
  dynamics::add_payload(loaded.robot, {.name = "", .link = arm().robot.n() - 1}, 2, {0.1, 0, 0.1},
                        Eigen::Matrix3d::Identity() * 0.01);
  std::vector<data::Dataset> with_load = clean(), with_offset = clean();
  with_load[2] = make_logs(loaded)[2];
  with_offset[2].tau.col(1).array() += 3;
  for (const std::vector<data::Dataset>* logs : {&with_load, &with_offset}) {
    const std::string doubts = doubts_of(arm().robot, *logs);
    EXPECT_THAT(doubts, Not(IsEmpty()));
    EXPECT_THAT(doubts, Not(HasSubstr("zero")));
  }
}

// A validation log of the same arm does not differ, one with a load, another day's friction or
// another zero does.
TEST(HeldOut, DiffersFromTheTrainingDataByLoadFrictionOrZero) {
  const std::span<const data::Dataset> training = std::span(clean()).first(2);
  const auto found_of = [&](const data::Dataset& held_out) {
    std::string text;
    const auto found = find_differences_from_training(arm().robot, training, {&held_out, 1}, {}, 1);
    for (const Fault& fault : found.at(0)) text += in_words(fault) + "\n";
    return text;
  };
  EXPECT_EQ(found_of(clean()[2]), "");

  Arm loaded = arm();
  dynamics::add_payload(loaded.robot, {.name = "", .link = arm().robot.n() - 1}, 2, {0.1, 0, 0.1},
                        Eigen::Matrix3d::Identity() * 0.01);
  EXPECT_THAT(found_of(make_logs(loaded)[2]), testing::ContainsRegex("load|contradict"));

  Arm other_day = arm();
  for (double& value : other_day.friction.theta) value *= value > 0.1 ? 0.6 : 1;
  EXPECT_THAT(found_of(make_logs(other_day)[2]), HasSubstr("riction"));

  data::Dataset moved = clean()[2];
  moved.q.col(1).array() += 0.03;
  EXPECT_THAT(found_of(moved), ContainsRegex("seed_3 by 0\\.0(2[7-9]|3)"));
}

}  // namespace
}  // namespace fricid::estimate
