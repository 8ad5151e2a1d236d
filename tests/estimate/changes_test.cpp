// What changes while an arm is logged is found and named; what does not, is not.
#include <gmock/gmock.h>

#include <fmt/ranges.h>

#include <array>
#include <cmath>

#include "arm_data.hpp"
#include "flywheel.hpp"
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

/// A log that begins with a rest of so many samples.
data::Dataset after_rest(const Arm& arm, const data::Dataset& log, int samples) {
  const auto n = static_cast<std::size_t>(arm.robot.n());
  dynamics::Workspace<double> ws(arm.robot);
  const std::vector<double> zero(n, 0.0);
  RowMatrix held(1, arm.robot.n());
  dynamics::rnea<double>(arm.robot, ws,
                         {arm.robot.pi.data(), static_cast<std::size_t>(arm.robot.pi.size())},
                         {log.q.row(0).data(), n}, zero, zero, {held.row(0).data(), n});
  data::Dataset out = log;
  const int length = samples + log.length();
  out.t = Eigen::VectorXd::LinSpaced(length, 0, (length - 1) / log.rate_hz);
  out.q.resize(length, log.n());
  out.tau.resize(length, log.n());
  out.q << log.q.row(0).replicate(samples, 1), log.q;
  out.tau << held.replicate(samples, 1), log.tau;
  return out;
}

// Pieces are stretches of the log, whether its joints move there or not.
TEST(Changes, AreNamedByTheTimeOfALogThatBeginsAtRest) {
  const Arm arm = coulomb_arm(5e-3);
  Arm loaded = arm;
  dynamics::add_payload(loaded.robot, {.name = "", .link = arm.robot.n() - 1}, 2, {0.1, 0, 0.1},
                        Eigen::Matrix3d::Identity() * 0.01);
  EXPECT_THAT(doubts_of(arm.robot, after_rest(arm, changing(arm, loaded), 12 * 250)),
              ContainsRegex("the load on .* changes, as between 24 to 30 s of .* and 30 to 36 s"));
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

// For five seconds that are in no piece of six.
TEST(Changes, BrakeThatDragsForSeconds) {
  const Arm arm = coulomb_arm(5e-3);
  const data::Dataset log = make_log(arm, kLong);
  data::Dataset dragging = log;
  for (int k = 14 * 250; k < 19 * 250; ++k)
    dragging.tau(k, 1) += 3.5 * std::copysign(1.0, log.q(k + 1, 1) - log.q(k - 1, 1));
  EXPECT_THAT(doubts_of(arm.robot, dragging),
              ContainsRegex(arm.robot.joints[1].name + ": its friction changes by a factor of "
                                                       "(0\\.[3-6]|[12]\\.).*a brake that drags"));
}

// A torque that goes with the angle of the gears, in logs in which each joint slides for some
// seconds.
TEST(Changes, RippleOfAShortLogIsNone) {
  const Arm arm = coulomb_arm(5e-3);
  for (const double peak_speed : {0.3, 0.6})
    for (const double seconds : {6.0, 9.0})
      for (const std::uint64_t seed : {1, 2, 4}) {
        data::Dataset log = make_log(arm, {.seconds = seconds,
                                           .peak_speed = peak_speed,
                                           .torque_noise = 0.1,
                                           .seed = seed,
                                           .repeats = false});
        log.tau.array() += 1.5 * (20 * log.q.array()).sin();
        EXPECT_THAT(doubts_of(arm.robot, log), testing::Not(HasSubstr("friction changes")))
            << peak_speed << " rad/s, " << seconds << " s, seed " << seed;
      }
}

// Strokes to and fro at one speed after the other, of a wheel whose friction falls,
// rises and falls with the speed.
TEST(Changes, StrokesAtRisingSpeedsAreNone) {
  constexpr double kRate = 250, kStretch = 9, kFc = 1.6, kFs = 2.4, kVs = 0.1, kFv = 0.5,
                   kStroke = 0.8;
  const Arm wheel = test::flywheel(0.3, 1);
  data::Dataset log;
  log.name = "strokes";
  log.joint_names = {wheel.robot.joints[0].name};
  log.rate_hz = kRate;
  log.t = Eigen::VectorXd::LinSpaced(9000, 0, 8999 / kRate);
  log.q.resize(9000, 1);
  log.tau.resize(9000, 1);
  Rng rng(5, 0);
  double q = 0, direction = 1;
  for (int k = 0; k < 9000; ++k) {
    const auto stretch = static_cast<std::size_t>(log.t[k] / kStretch);
    const double speed = std::array{0.1, 0.4, 1.0, 2.0}[stretch];
    if (std::abs(q) > kStroke) direction = q > 0 ? -1 : 1;
    q += direction * speed / kRate;
    log.q(k, 0) = q;
    const double friction = kFc * (1 + 0.35 * std::exp(-std::pow((speed - 1) / 0.4, 2))) +
                            (kFs - kFc) * std::exp(-std::pow(speed / kVs, 2)) + kFv * speed;
    log.tau(k, 0) = direction * friction + 0.02 * rng.normal();
  }
  EXPECT_THAT(doubts_of(wheel.robot, log), testing::Not(HasSubstr("changes")));
}

// A pendulum that swings about another angle in each stretch, so that its weight loads the joint
// by more or less, and with it its friction.
TEST(Changes, FrictionThatGrowsWithTheLoadIsNone) {
  constexpr double kRate = 250, kStretch = 9, kWeight = 10, kFc = 1, kFv = 0.5, kGrowth = 0.2;
  Arm pendulum = test::flywheel(0.3, 1);
  pendulum.robot.pi[1] = 1;  // mass times distance
  pendulum.robot.gravity = {-kWeight, 0, 0};
  const auto doubts = [&](double growth, double growth_later) {
    data::Dataset log;
    log.name = "swings";
    log.joint_names = {pendulum.robot.joints[0].name};
    log.rate_hz = kRate;
    log.t = Eigen::VectorXd::LinSpaced(9000, 0, 8999 / kRate);
    log.q.resize(9000, 1);
    log.tau.resize(9000, 1);
    Rng rng(5, 0);
    for (int k = 0; k < 9000; ++k) {
      const auto stretch = static_cast<std::size_t>(log.t[k] / kStretch);
      const double centre = std::array{0.1, 0.5, 1.0, 1.5}[stretch], w = 2 + 0.2 * log.t[k] / 36;
      const double v = 0.5 * w * std::cos(w * log.t[k]), a = -w * w * 0.5 * std::sin(w * log.t[k]);
      log.q(k, 0) = centre + 0.5 * std::sin(w * log.t[k]);
      const double load = 0.3 * a - kWeight * std::sin(log.q(k, 0));
      const double now = stretch < 2 ? growth : growth_later;
      log.tau(k, 0) =
          load + std::copysign(kFc + now * std::abs(load), v) + kFv * v + 0.02 * rng.normal();
    }
    return doubts_of(pendulum.robot, log);
  };
  EXPECT_THAT(doubts(kGrowth, kGrowth), testing::Not(HasSubstr("changes")));
  EXPECT_THAT(doubts(kGrowth, 3 * kGrowth), HasSubstr("friction changes"));
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
