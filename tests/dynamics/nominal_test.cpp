// What a robot's file leaves out is named, or guessed.
#include "fricid/dynamics/nominal.hpp"

#include <gmock/gmock.h>

#include "fricid/base/error.hpp"
#include "fricid/dynamics/physical_inertia.hpp"
#include "robots.hpp"

namespace fricid::dynamics::test {
namespace {

using testing::HasSubstr;

/// The link that joint j moves becomes a point on the joint's axis.
void make_point(RobotModel& robot, int j) {
  auto link = robot.pi.segment<10>(10 * j);
  const Joint& joint = robot.joints[static_cast<std::size_t>(j)];
  const double m = link[0];
  link.setZero();
  add_payload(robot, Frame{.name = "", .link = j}, m, 0.05 * joint.axis, Eigen::Matrix3d::Zero());
}

std::string refusal(const RobotModel& robot) {
  try {
    require_inertia(robot, "arm.urdf");
  } catch (const UserError& error) {
    return error.what();
  }
  return "no error";
}

TEST(Nominal, AJointThatNothingResistsIsNamedWithItsRemedy) {
  const RobotModel whole = load("kr6_r700/kr6_r700.urdf");
  RobotModel bare = whole;
  bare.pi.segment(bare.armature_begin(), bare.n()).setZero();
  EXPECT_EQ(refusal(bare), "no error");

  RobotModel singular = bare;
  make_point(singular, 5);
  const std::string text = refusal(singular);
  EXPECT_THAT(text, HasSubstr("arm.urdf: joint joint_a6 "));
  EXPECT_THAT(text, HasSubstr("link link_6"));
  EXPECT_THAT(text, HasSubstr("<fricid armature=\"0.077\"/>"));  // 0.03 s 27.4 N m / 10.73 rad/s

  RobotModel with_armature = whole;  // an armature resists, whatever the link is
  make_point(with_armature, 5);
  EXPECT_EQ(refusal(with_armature), "no error");
}

TEST(Nominal, NoRobotOfOursIsRefused) {
  for (const RobotModel& robot : all_robots()) EXPECT_EQ(refusal(robot), "no error") << robot.name;
}

// Reference: armatures of the robots that state them.
TEST(Nominal, UsualArmatureIsWithinAFactorOfFourOfStatedOnes) {
  for (const char* path : {"kr6_r700/kr6_r700.urdf", "kuka_kr300/kuka_kr300.urdf"}) {
    const RobotModel robot = load(path);
    const VectorXd usual = usual_armature(robot);
    for (int j = 0; j < robot.n(); ++j) {
      const double ratio = usual[j] / robot.pi[robot.armature_begin() + j];
      EXPECT_GT(ratio, 1. / 4) << path << " joint " << j;
      EXPECT_LT(ratio, 4) << path << " joint " << j;
    }
  }
}

TEST(Nominal, CompleteGuessesOnlyWhatIsMissing) {
  const RobotModel whole = load("kr6_r700/kr6_r700.urdf");
  const Nominal unchanged = complete(whole);
  EXPECT_TRUE(unchanged.guesses.empty());
  EXPECT_EQ(unchanged.robot.pi, whole.pi);

  RobotModel poor = whole;
  poor.pi.segment(poor.armature_begin(), poor.n()).setZero();
  make_point(poor, 5);
  const Nominal guessed = complete(poor);
  EXPECT_EQ(guessed.guesses.armature, (std::vector<int>{0, 1, 2, 3, 4, 5}));
  EXPECT_EQ(guessed.guesses.inertia, (std::vector<int>{5}));
  for (int j = 0; j < poor.n(); ++j)
    EXPECT_TRUE(is_physical(guessed.robot.pi.segment<10>(10 * j))) << j;
  EXPECT_EQ(guessed.robot.pi.head(50), poor.pi.head(50));
}

TEST(Nominal, AMendedInertiaIsAGuess) {
  RobotModel mended = load("kr6_r700/kr6_r700.urdf");
  mended.mended_links = {mended.joints[2].link};
  const Nominal guessed = complete(mended);
  EXPECT_EQ(guessed.guesses.inertia, (std::vector<int>{2}));
  EXPECT_EQ(guessed.robot.pi, mended.pi);
}

}  // namespace
}  // namespace fricid::dynamics::test
