#include "fricid/dynamics/base_parameters.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <numbers>

#include "robots.hpp"

namespace fricid::dynamics::test {
namespace {

TEST(BaseParameters, PredictLikeAllParameters) {
  for (const RobotModel& model : all_robots()) {
    SCOPED_TRACE(model.name);
    const BaseParameters base = base_parameters(model);
    const VectorXd pi_b = base.K * model.pi;
    Robot robot(model);
    for (int k = 0; k < 200; ++k) {
      const State s = random_state(model, k);
      const MatrixXd Y = robot.regressor(s.q, s.v, s.a);
      EXPECT_TRUE(close(Y(Eigen::all, base.columns) * pi_b, Y * model.pi, 1e-10));
    }
  }
}

TEST(BaseParameters, AreIndependentAndClear) {
  for (const RobotModel& model : all_robots()) {
    SCOPED_TRACE(model.name);
    const BaseParameters base = base_parameters(model);
    const auto b = static_cast<int>(base.columns.size());
    EXPECT_EQ(base.K(Eigen::all, base.columns), MatrixXd::Identity(b, b));
    EXPECT_GT(base.gap, 1e6);
    EXPECT_EQ(static_cast<int>(base.names.size()), b);
    for (const int k : base.unidentifiable) EXPECT_EQ(base.K.col(k).norm(), 0);
  }
}

// Hand count for one pendulum about y: m cx, m cz through gravity, Iyy with the armature.
TEST(BaseParameters, OfThePendulum) {
  const BaseParameters base = base_parameters(load("test/pendulum.urdf"));
  EXPECT_THAT(base.names, testing::ElementsAre("pivot m cx", "pivot m cz", "pivot Iyy + pivot Ia"));
}

// The textbook grouping (Khalil & Dombre 2002, ch. 9): the second mass counts at the elbow, 0.5 m
// out; the armature of the second joint alone is told from its inertia.
TEST(BaseParameters, OfThePlanarArm) {
  const BaseParameters base = base_parameters(load("test/planar_2r.urdf"));
  EXPECT_THAT(base.names,
              testing::ElementsAre("shoulder m cx + 0.5 elbow m", "shoulder m cz",
                                   "shoulder Iyy + 0.25 elbow m + shoulder Ia", "elbow m cx",
                                   "elbow m cz", "elbow Iyy", "elbow Ia"));
}

// Links 1, 2 and 4 turn about parallel vertical axes and gravity acts on the spindle alone.
TEST(BaseParameters, OfTheScara) {
  const RobotModel model = load("test/scara.urdf");
  const BaseParameters base = base_parameters(model);
  EXPECT_EQ(base.columns.size(), 11u);
  // heights never matter
  const auto names = model.parameter_names();
  for (const int k : base.unidentifiable) EXPECT_NE(names[static_cast<size_t>(k)], "joint_3 m");
  for (const char* name : {"joint_1 m", "joint_1 m cz", "joint_2 m cz", "joint_4 Ixx"}) {
    const auto k = std::find(names.begin(), names.end(), name) - names.begin();
    EXPECT_THAT(base.unidentifiable, testing::Contains(static_cast<int>(k)));
  }
}

// 36 inertial ones as for any six-joint arm with a vertical first axis (Khalil & Dombre 2002, ch.
// 9), and the armatures of joints 3 to 6: those of 1 and 2 join Izz of link 1 and Iyy of link 2.
TEST(BaseParameters, OfTheKr6) {
  const RobotModel model = load("kr6_r700/kr6_r700.urdf");
  const BaseParameters base = base_parameters(model);
  const auto inertial =
      std::count_if(base.columns.begin(), base.columns.end(), [](int k) { return k < 60; });
  EXPECT_EQ(inertial, 36);
  EXPECT_EQ(base.columns.size(), 40u);
  EXPECT_THAT(
      base.names,
      testing::Contains("joint_a2 m cx + 0.315 joint_a3 m + 0.315 joint_a4 m + 0.315 joint_a5 m + "
                        "0.315 joint_a6 m"));
  EXPECT_THAT(base.names, testing::Contains("joint_a6 Iyy - joint_a6 Izz"));
}

// Hung on a wall, gravity turns with the first joint: m cx and m cy of link 1 become visible.
// Limits of a billion radians, as converters put in: the angles that are tried have digits left.
TEST(BaseParameters, DoNotDependOnLimitsThatNobodyMeant) {
  RobotModel model = load("kr6_r700/kr6_r700.urdf");
  const BaseParameters base = base_parameters(model);
  for (Joint& joint : model.joints) joint.lower = -1e9, joint.upper = 1e9;
  const BaseParameters wide = base_parameters(model);
  EXPECT_EQ(wide.columns, base.columns);
  ASSERT_EQ(wide.K.rows(), base.K.rows());
  EXPECT_LT((wide.K - base.K).cwiseAbs().maxCoeff(), 1e-10);
  for (const Joint& joint : model.joints) {
    EXPECT_EQ(travel_of(joint).lower, -std::numbers::pi);
    EXPECT_EQ(travel_of(joint).upper, std::numbers::pi);
  }
}

TEST(BaseParameters, OfTheKr6OnAWallAreTwoMore) {
  RobotModel model = load("kr6_r700/kr6_r700.urdf");
  model.gravity = {9.81, 0, 0};
  EXPECT_EQ(base_parameters(model).columns.size(), 42u);
}

TEST(BaseParameters, AreTheSameEveryTime) {
  const RobotModel model = load("test/branched.urdf");
  const BaseParameters first = base_parameters(model), second = base_parameters(model);
  EXPECT_EQ(first.columns, second.columns);
  EXPECT_EQ(first.K, second.K);
  EXPECT_EQ(first.names, second.names);
}

}  // namespace
}  // namespace fricid::dynamics::test
