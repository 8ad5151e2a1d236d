// Robots whose equations fit on a line, and the published kinematics of the KR 6 R700.
#include <gtest/gtest.h>

#include "fricid/base/error.hpp"
#include "robots.hpp"

namespace fricid::dynamics::test {
namespace {

constexpr double kGravity = 9.81;

TEST(ClosedForm, Pendulum) {
  const RobotModel model = load("test/pendulum.urdf");
  constexpr double m = 2, l = 0.3, I = 0.015, J = 0.01;
  Robot robot(model);
  for (const double q : {-2.0, 0.0, 0.4, 1.5}) {
    const VectorXd q_{{q}}, v{{3.0}}, a{{-1.2}};
    EXPECT_NEAR(robot.rnea(q_, v, a)(0),
                (I + m * l * l + J) * -1.2 + m * kGravity * l * std::sin(q), 1e-13);
  }
}

TEST(ClosedForm, Planar2R) {
  const RobotModel model = load("test/planar_2r.urdf");
  constexpr double l1 = 0.5, c1 = 0.25, m1 = 3, I1 = 0.08, c2 = 0.18, m2 = 2, I2 = 0.03;
  Robot robot(model);
  for (int k = 0; k < 100; ++k) {
    const State s = random_state(model, k);
    const double cos2 = std::cos(s.q(1)), sin2 = std::sin(s.q(1));
    const double g1 = kGravity * std::cos(s.q(0)), g12 = kGravity * std::cos(s.q(0) + s.q(1));
    MatrixXd M(2, 2);
    M(0, 0) = I1 + m1 * c1 * c1 + I2 + m2 * (l1 * l1 + c2 * c2 + 2 * l1 * c2 * cos2);
    M(0, 1) = M(1, 0) = I2 + m2 * (c2 * c2 + l1 * c2 * cos2);
    M(1, 1) = I2 + m2 * c2 * c2;
    const double v1 = s.v(0), v2 = s.v(1);
    const VectorXd h{
        {-m2 * l1 * c2 * sin2 * (2 * v1 * v2 + v2 * v2) + (m1 * c1 + m2 * l1) * g1 + m2 * c2 * g12,
         m2 * l1 * c2 * sin2 * v1 * v1 + m2 * c2 * g12}};
    EXPECT_TRUE(close(robot.rnea(s.q, s.v, s.a), M * s.a + h, 1e-13));
    EXPECT_LE((robot.mass(s.q) - M).cwiseAbs().maxCoeff(), 1e-14);
  }
}

TEST(ClosedForm, ScaraGravityIsOnTheSpindleAlone) {
  const RobotModel model = load("test/scara.urdf");
  Robot robot(model);
  const VectorXd expected{{0, 0, -1.4 * kGravity, 0}};
  for (int k = 0; k < 100; ++k)
    EXPECT_TRUE(close(robot.gravity(random_state(model, k).q), expected, 1e-13));
}

// A slider on a turntable: radius q2 from the axis, mass 1 kg. Coriolis torque 2 m r v1 v2 on the
// table, centrifugal force m r v1^2 pulled back by the slide.
TEST(ClosedForm, SliderOnTurntable) {
  const RobotModel model = parse_urdf(R"(<robot name="slider">
    <link name="base"/>
    <link name="table"><inertial><mass value="2"/>
      <inertia ixx="0.1" iyy="0.1" izz="0.2" ixy="0" ixz="0" iyz="0"/></inertial></link>
    <link name="slider"><inertial><mass value="1"/>
      <inertia ixx="0.01" iyy="0.01" izz="0.01" ixy="0" ixz="0" iyz="0"/></inertial></link>
    <joint name="turn" type="continuous"><parent link="base"/><child link="table"/>
      <axis xyz="0 0 1"/></joint>
    <joint name="slide" type="prismatic"><parent link="table"/><child link="slider"/>
      <axis xyz="1 0 0"/><limit lower="0" upper="2" velocity="1" effort="9"/></joint>
    </robot>)",
                                      "slider.urdf");
  Robot robot(model);
  const double r = 0.7, v1 = 2, v2 = -0.5, a1 = 3, a2 = 1.5;
  const VectorXd tau = robot.rnea(VectorXd{{1.1, r}}, VectorXd{{v1, v2}}, VectorXd{{a1, a2}});
  EXPECT_NEAR(tau(0), (0.21 + r * r) * a1 + 2 * r * v1 * v2, 1e-14);
  EXPECT_NEAR(tau(1), a2 - r * v1 * v1, 1e-14);
}

// Flange in base_link from kuka_kr6_support/urdf/kr6r700sixx_macro.xacro of
// ros-industrial/kuka_experimental at commit e78bbd15.
TEST(ClosedForm, Kr6FlangeIsWhereThePublicModelPutsIt) {
  const RobotModel model = load("kr6_r700/kr6_r700.urdf");
  constexpr double k90 = std::numbers::pi / 2, kHalf = 0.70710678118654752;
  const struct {
    std::vector<double> q;
    Vector3d p;
    Eigen::Quaterniond R;
  } poses[] = {{{0, 0, 0, 0, 0, 0}, {0.785, 0, 0.435}, {1, 0, 0, 0}},
               {{0, -k90, k90, 0, 0, 0}, {0.47, 0, 0.75}, {1, 0, 0, 0}},
               {{0, -k90, 0, 0, 0, 0}, {-0.01, 0, 1.16}, {kHalf, 0, -kHalf, 0}},
               {{0, -k90, k90, 0, k90, 0}, {0.39, 0, 0.67}, {kHalf, 0, kHalf, 0}},
               {{k90, -k90, k90, 0, 0, 0}, {0, -0.47, 0.75}, {kHalf, 0, 0, -kHalf}}};
  for (const auto& pose : poses) {
    const Pose flange = frame_pose(model, "flange", pose.q);
    EXPECT_LT((flange.p - pose.p).norm(), 1e-9);
    EXPECT_LT((flange.R - pose.R.toRotationMatrix()).norm(), 1e-9);
  }
}

TEST(ClosedForm, UnknownFrameNamesTheKnownOnes) {
  const RobotModel model = load("test/pendulum.urdf");
  try {
    frame_pose(model, "flnge", std::vector<double>{0});
    FAIL();
  } catch (const UserError& error) {
    EXPECT_STREQ(error.what(), "pendulum: unknown frame \"flnge\"; known frames: base, bob");
  }
}

}  // namespace
}  // namespace fricid::dynamics::test
