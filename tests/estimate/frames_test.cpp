// A robot's file with another geometry than the arm is told with the joint and how far it is off.
#include <gmock/gmock.h>

#include <fmt/ranges.h>

#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Geometry>

#include "arm_data.hpp"
#include "fricid/estimate/rigid_body/identifiability.hpp"

namespace fricid::estimate {
namespace {

using testing::HasSubstr;
using testing::Not;

/// What the file of the small arm has against two logs of an arm, of which one joint may have been
/// read as if its gear had another ratio, and its torque by a factor.
std::string doubts_of(const Arm& arm, int joint = 0, double ratio = 1, double torque = 1) {
  std::vector<signals::Recording> recordings;
  for (const std::uint64_t seed : {1, 2}) {
    data::Dataset log = make_log(arm, {.seconds = 24, .torque_noise = 0.03, .seed = seed});
    log.q.col(joint) /= ratio;
    log.tau.col(joint) *= ratio * torque;
    recordings.push_back(signals::make_recording(std::move(log), 10));
  }
  return fmt::format("{}", fmt::join(examine_data(small_arm(), recordings, {}).doubts, "\n"));
}

/// The three numbers behind a text.
Eigen::Vector3d vector_behind(const std::string& text, const std::string& key) {
  const std::size_t at = text.find(key);
  if (at == std::string::npos) return Eigen::Vector3d::Constant(std::nan(""));
  std::string rest = text.substr(at + key.size());
  Eigen::Vector3d x;
  for (double& value : x) {
    std::size_t end = 0;
    value = std::stod(rest, &end);
    rest = rest.substr(end);
  }
  return x;
}

Arm turned(Arm arm, std::size_t joint, double angle, const Eigen::Vector3d& axis) {
  dynamics::Joint& moved = arm.robot.joints[joint];
  moved.R0 = moved.R0 * Eigen::AngleAxisd(angle, axis).toRotationMatrix();
  return arm;
}

TEST(Frames, ALinkOfAnotherLength) {
  for (const double by : {0.08, -0.12}) {
    Arm arm = coulomb_arm(5e-3);
    arm.robot.joints[2].p0.x() += by;
    const std::string doubts = doubts_of(arm);
    EXPECT_THAT(doubts, HasSubstr("j3: its axis lies elsewhere than in the robot's file, by ("));
    EXPECT_NEAR(vector_behind(doubts, "by (").x(), by, 0.01) << doubts;
    EXPECT_THAT(doubts, Not(HasSubstr("j2: ")));
  }
}

TEST(Frames, AnAxisThatAForgottenTurnPutsElsewhere) {
  const std::string doubts =
      doubts_of(turned(coulomb_arm(5e-3), 2, std::numbers::pi / 2, Eigen::Vector3d::UnitX()));
  EXPECT_THAT(doubts, HasSubstr("j3: its axis lies elsewhere"));
  EXPECT_NEAR(vector_behind(doubts, "turned by (").norm(), std::numbers::pi / 2, 0.05) << doubts;
}

TEST(Frames, AnotherZeroOfAJointIsToldAsThat) {
  for (const double by : {0.2, -1.2}) {
    const std::string doubts =
        doubts_of(turned(coulomb_arm(5e-3), 1, by, small_arm().joints[1].axis));
    const std::string key = "j2: its zero lies ";
    const std::size_t at = doubts.find(key);
    ASSERT_NE(at, std::string::npos) << doubts;
    EXPECT_NEAR(std::stod(doubts.substr(at + key.size())), by, 0.02) << doubts;
  }
}

// Reference: the ratio by which motion and torque were read wrong.
TEST(Frames, AGearOfAnotherRatioIsToldWithIt) {
  for (const int joint : {1, 2})
    for (const double ratio : {1.1, 0.7}) {
      const std::string doubts = doubts_of(coulomb_arm(5e-3), joint, ratio);
      const std::string key = fmt::format("j{}: its gear has another ratio: it moves ", joint + 1);
      ASSERT_THAT(doubts, HasSubstr(key));
      EXPECT_NEAR(std::stod(doubts.substr(doubts.find(key) + key.size())), ratio, 0.02) << doubts;
    }
  EXPECT_THAT(doubts_of(coulomb_arm(5e-3), 2, 1, 1.3), Not(HasSubstr("ratio: it moves")));
}

TEST(Frames, AFewMillimetresAndFrictionWithMemoryAreNoFault) {
  Arm arm = coulomb_arm(5e-3);
  arm.robot.joints[2].p0.x() += 0.003;
  EXPECT_EQ(doubts_of(arm), "");
  Arm hysteretic = coulomb_arm();
  hysteretic.friction = same_law("dahl", {4, 500, 2}, hysteretic.robot.n());
  EXPECT_THAT(doubts_of(hysteretic), Not(HasSubstr("lies")));
}

}  // namespace
}  // namespace fricid::estimate
