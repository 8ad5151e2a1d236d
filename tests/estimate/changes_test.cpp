// What changes while an arm is logged is found and named; what does not, is not.
#include <gmock/gmock.h>

#include <fmt/ranges.h>

#include "arm_data.hpp"
#include "fricid/estimate/rigid_body/identifiability.hpp"

namespace fricid::estimate {
namespace {

using testing::ContainsRegex;
using testing::HasSubstr;
using testing::IsEmpty;

const LogOptions kLong{.seconds = 36, .torque_noise = 0.1};

std::string doubts_of(const dynamics::RobotModel& robot, const data::Dataset& log) {
  const std::vector<signals::Recording> recordings{signals::make_recording(log, 10)};
  return fmt::format("{}", fmt::join(examine_data(robot, recordings, {}).doubts, "\n"));
}

/// One reference tracked by an arm, from the middle on by another.
data::Dataset changing(const Arm& first, const Arm& then) {
  data::Dataset log = make_log(first, kLong);
  const data::Dataset other = make_log(then, kLong);
  const int half = log.length() / 2;
  log.q.bottomRows(half) = other.q.bottomRows(half);
  log.tau.bottomRows(half) = other.tau.bottomRows(half);
  return log;
}

TEST(Changes, ThereAreNoneInALogThatHasNone) {
  const Arm arm = coulomb_arm(5e-3);
  EXPECT_THAT(doubts_of(arm.robot, make_log(arm, kLong)), IsEmpty());
}

TEST(Changes, LoadThatIsPickedUp) {
  const Arm arm = coulomb_arm(5e-3);
  Arm loaded = arm;
  dynamics::add_payload(loaded.robot, {.name = "", .link = arm.robot.n() - 1}, 2, {0.1, 0, 0.1},
                        Eigen::Matrix3d::Identity() * 0.01);
  EXPECT_THAT(doubts_of(arm.robot, changing(arm, loaded)),
              ContainsRegex("the load on .* changes, as between 12 to 18 s of .* and 18 to 24 s"));
}

/// The arm with its friction times a factor.
Arm with_friction(Arm arm, double factor) {
  for (int j = 0; j < arm.robot.n(); ++j)
    for (const friction::Role role : {friction::Role::kCoulomb, friction::Role::kViscous})
      if (const int at = friction::find_parameter(arm.friction.model, j, role); at >= 0)
        arm.friction.theta[static_cast<std::size_t>(at)] *= factor;
  return arm;
}

TEST(Changes, FrictionThatFalls) {
  const Arm cold = coulomb_arm(5e-3);
  EXPECT_THAT(doubts_of(cold.robot, changing(cold, with_friction(cold, 0.7))),
              ContainsRegex("friction changes by a factor of 0\\.(69|7)"));
}

// Beside a longer log that noise dominates.
TEST(Changes, FrictionThatFallsInOneOfTheLogs) {
  const Arm cold = coulomb_arm(5e-3);
  const data::Dataset warms = changing(cold, with_friction(cold, 0.7)),
                      noisy = make_log(cold, {.seconds = 72, .torque_noise = 2, .seed = 2});
  std::vector<signals::Recording> recordings;
  for (const data::Dataset& log : {warms, noisy})
    recordings.push_back(signals::make_recording(log, 10));
  EXPECT_THAT(fmt::format("{}", fmt::join(examine_data(cold.robot, recordings, {}).doubts, "\n")),
              ContainsRegex("friction changes by a factor of 0\\.(69|7).* of seed_1 to"));
}

// As any gear warms, and no scale of the torque changes instead.
TEST(Changes, FrictionThatFallsALittle) {
  const Arm cold = coulomb_arm(5e-3);
  EXPECT_THAT(doubts_of(cold.robot, changing(cold, with_friction(cold, 0.86))), IsEmpty());
}

// A joint that stands for a while says nothing of its friction then.
TEST(Changes, FrictionOfAJointThatStands) {
  const Arm cold = coulomb_arm(5e-3);
  LogOptions others = kLong;
  others.moving = 0;
  data::Dataset log = changing(cold, with_friction(cold, 0.86));
  const data::Dataset standing = make_log(cold, others);
  const int piece = log.length() / 6;
  log.q.topRows(piece) = standing.q.topRows(piece);
  log.tau.topRows(piece) = standing.tau.topRows(piece);
  EXPECT_THAT(doubts_of(cold.robot, log), testing::Not(HasSubstr("friction changes")));
}

// In steps and as a drift: the second joint's constant, and its offset.
TEST(Changes, FactorAndOffsetOfTheTorque) {
  const Arm arm = coulomb_arm(5e-3);
  const std::string& joint = arm.robot.joints[1].name;
  const data::Dataset log = make_log(arm, kLong);
  for (const bool drifts : {false, true}) {
    data::Dataset scaled = log, moved = log;
    for (int k = 0; k < log.length(); ++k) {
      const double past = static_cast<double>(k) / log.length();
      const double share = drifts ? past : past > 0.5;
      scaled.tau(k, 1) *= 1 + 0.15 * share;
      moved.tau(k, 1) += 3 * share;
    }
    EXPECT_THAT(doubts_of(arm.robot, scaled),
                ContainsRegex(joint + ": its torque changes its scale: by a factor of 1\\.1[2-6]"));
    EXPECT_THAT(doubts_of(arm.robot, moved),
                ContainsRegex(joint + ": a constant torque comes and goes: (2\\.[4-9]|3)"));
  }
}

// A factor that is wrong throughout is another fault.
TEST(Changes, WrongFactorIsNone) {
  const Arm arm = coulomb_arm(5e-3);
  data::Dataset log = make_log(arm, kLong);
  log.tau.col(1) *= 1.3;
  EXPECT_THAT(doubts_of(arm.robot, log), testing::Not(HasSubstr("changes")));
}

}  // namespace
}  // namespace fricid::estimate
