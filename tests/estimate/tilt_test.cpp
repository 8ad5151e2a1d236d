// A base that stands otherwise than its mount says is told with its angles.
#include <gmock/gmock.h>

#include <fmt/ranges.h>

#include <cmath>
#include <string>
#include <vector>

#include <Eigen/Geometry>

#include "arm_data.hpp"
#include "fricid/estimate/rigid_body/identifiability.hpp"

namespace fricid::estimate {
namespace {

using testing::HasSubstr;
using testing::Not;

Arm tilted(Arm arm, double roll, double pitch) {
  const Eigen::Matrix3d mount = (Eigen::AngleAxisd(pitch, Eigen::Vector3d::UnitY()) *
                                 Eigen::AngleAxisd(roll, Eigen::Vector3d::UnitX()))
                                    .toRotationMatrix();
  arm.robot.gravity = mount.transpose() * arm.robot.gravity;
  return arm;
}

/// What an upright robot has against two logs of an arm.
std::string doubts_of(const Arm& arm) {
  std::vector<signals::Recording> recordings;
  for (const std::uint64_t seed : {1, 2})
    recordings.push_back(signals::make_recording(
        make_log(arm, {.seconds = 24, .torque_noise = 0.1, .seed = seed}), 10));
  return fmt::format("{}", fmt::join(examine_data(small_arm(), recordings, {}).doubts, "\n"));
}

TEST(Tilt, OfTheBaseIsFoundWithItsAngles) {
  for (const auto& [roll, pitch] : {std::pair{0.05, -0.03}, {-0.4, 0.2}, {0.0, 0.03}}) {
    const std::string doubts = doubts_of(tilted(coulomb_arm(5e-3), roll, pitch));
    const std::string key = "mount_rpy = [";
    const std::size_t at = doubts.find(key);
    ASSERT_NE(at, std::string::npos) << doubts;
    std::size_t end = 0;
    const std::string angles = doubts.substr(at + key.size());
    EXPECT_NEAR(std::stod(angles, &end), roll, 3e-3) << doubts;
    EXPECT_NEAR(std::stod(angles.substr(end + 1)), pitch, 3e-3) << doubts;
  }
}

TEST(Tilt, IsNotTakenForASpringOrAScaleAndTheyNotForIt) {
  const std::string doubts = doubts_of(tilted(coulomb_arm(5e-3), 0.1, 0.1));
  EXPECT_THAT(doubts, Not(HasSubstr("a spring")));
  EXPECT_THAT(doubts, Not(HasSubstr("torque constant")));
  Arm sprung = coulomb_arm(5e-3);
  dynamics::add_linear_torque(
      sprung.robot,
      {.name = "spring", .joint = 1, .shape = dynamics::LinearTorque::Shape::kLinear, .k = 1});
  sprung.robot.pi[sprung.robot.parameter_count() - 1] = 15;
  EXPECT_THAT(doubts_of(sprung), Not(HasSubstr("gravity points")));
}

TEST(Tilt, OfAFewMilliradiansAndFrictionWithMemoryAreNoFault) {
  EXPECT_EQ(doubts_of(tilted(coulomb_arm(5e-3), 0.005, 0)), "");
  Arm hysteretic = coulomb_arm();
  hysteretic.friction = same_law("dahl", {4, 500, 2}, hysteretic.robot.n());
  EXPECT_THAT(doubts_of(hysteretic), Not(HasSubstr("gravity points")));
}

}  // namespace
}  // namespace fricid::estimate
