// Inertia that is physical by construction, and payloads.
#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>

#include "fricid/dynamics/physical_inertia.hpp"
#include "robots.hpp"

namespace fricid::dynamics::test {
namespace {

Vector10 random_eta(std::uint64_t stream, double scale) {
  Rng rng(3, stream);
  Vector10 eta;
  for (double& x : eta) x = scale * rng.normal();
  return eta;
}

TEST(LogCholesky, RoundTrip) {
  for (std::uint64_t k = 0; k < 1000; ++k) {
    const Vector10 eta = random_eta(k, 1);
    EXPECT_TRUE(close(log_cholesky_from_inertia(inertia_from_log_cholesky(eta)), eta, 1e-9));
  }
  const RobotModel model = load("kr6_r700/kr6_r700.urdf");
  for (int i = 0; i < model.n(); ++i) {
    const Vector10 pi = model.pi.segment<10>(10 * i);
    EXPECT_TRUE(close(inertia_from_log_cholesky(log_cholesky_from_inertia(pi)), pi, 1e-14));
  }
}

// A fit that thins a link to a disc ends where the pseudo-inertia is singular to rounding.
TEST(LogCholesky, RoundTripOfBodiesWithoutThickness) {
  for (std::uint64_t k = 0; k < 300; ++k) {
    Vector10 eta = random_eta(k, 1);
    eta(1 + static_cast<int>(k % 3)) = -25;
    if (k % 2 == 0) eta(1 + static_cast<int>((k + 1) % 3)) = -40;
    const Vector10 pi = inertia_from_log_cholesky(eta);
    const Vector10 again = inertia_from_log_cholesky(log_cholesky_from_inertia(pi));
    EXPECT_LT((again - pi).norm(), 1e-7 * pi.norm()) << k;
  }
}

TEST(LogCholesky, MassAndCentreAreReadOff) {
  // alpha scales all: m = e^(2 alpha); t is the centre of mass
  Vector10 eta = Vector10::Zero();
  eta(0) = 0.5 * std::log(3.0);
  eta.tail<3>() << 0.1, -0.2, 0.3;
  const Vector10 pi = inertia_from_log_cholesky(eta);
  EXPECT_NEAR(pi(0), 3, 1e-14);
  EXPECT_TRUE(close(VectorXd(pi.segment<3>(1)), VectorXd{{0.3, -0.6, 0.9}}, 1e-14));
}

TEST(LogCholesky, JacobianEqualsCentralDifferences) {
  constexpr double kStep = 1e-6;
  for (std::uint64_t k = 0; k < 100; ++k) {
    const Vector10 eta = random_eta(k, 0.7);
    Eigen::Matrix<double, 10, 10> jacobian;
    inertia_from_log_cholesky(eta, &jacobian);
    for (int i = 0; i < 10; ++i) {
      const Vector10 step = kStep * Vector10::Unit(i);
      const Vector10 slope =
          (inertia_from_log_cholesky(eta + step) - inertia_from_log_cholesky(eta - step)) /
          (2 * kStep);
      EXPECT_TRUE(close(VectorXd(jacobian.col(i)), slope, 1e-8)) << i;
    }
  }
}

TEST(LogCholesky, AnyVectorIsABody) {
  for (std::uint64_t k = 0; k < 1000; ++k) {
    const Vector10 pi = inertia_from_log_cholesky(random_eta(k, 1.5));
    EXPECT_GT(pi(0), 0);
    EXPECT_TRUE(is_physical(pi)) << pi.transpose();
  }
}

TEST(PseudoInertia, HoldsTheSecondMomentOfMass) {
  // two points of 1 and 2 kg
  const Vector3d a(0.1, 0.2, -0.3), b(-0.2, 0.4, 0.1);
  Vector10 pi = Vector10::Zero();
  const auto add = [&pi](double m, const Vector3d& r) {
    const Eigen::Matrix3d I =
        m * (r.squaredNorm() * Eigen::Matrix3d::Identity() - r * r.transpose());
    Vector10 point;
    point << m, m * r, I(0, 0), I(0, 1), I(1, 1), I(0, 2), I(1, 2), I(2, 2);
    pi += point;
  };
  add(1, a);
  add(2, b);
  const Eigen::Matrix3d second = a * a.transpose() + 2 * b * b.transpose();
  const Eigen::Matrix4d J = pseudo_inertia(pi);
  EXPECT_LT((J.topLeftCorner<3, 3>() - second).norm(), 1e-15);
  EXPECT_LT((J.topRightCorner<3, 1>() - (a + 2 * b)).norm(), 1e-15);
  EXPECT_EQ(J(3, 3), 3);
  EXPECT_FALSE(is_physical(pi, 1e-12)) << "two points have no volume";
}

TEST(PseudoInertia, RefusesWhatNoBodyHas) {
  const RobotModel model = load("kr6_r700/kr6_r700.urdf");
  const Vector10 link = model.pi.segment<10>(10);
  EXPECT_TRUE(is_physical(link));
  Vector10 pi = link;
  pi(0) = -pi(0);
  EXPECT_FALSE(is_physical(pi)) << "negative mass";
  pi = link;
  pi(1) *= 10;
  EXPECT_FALSE(is_physical(pi)) << "centre of mass outside the body";
  pi = link;
  pi(4) = 2 * (pi(6) + pi(9));
  EXPECT_FALSE(is_physical(pi)) << "triangle inequality";
  pi = link;
  pi(4) = std::nan("");
  EXPECT_FALSE(is_physical(pi));
}

// A payload is the same as a link behind a fixed joint.
TEST(Payload, EqualsAFixedLink) {
  const std::string head = R"(<robot name="r"><link name="base"/>
    <link name="arm"><inertial><origin xyz="0.2 0 0"/><mass value="2"/>
      <inertia ixx="0.01" iyy="0.05" izz="0.05" ixy="0" ixz="0" iyz="0"/></inertial></link>
    <joint name="j" type="continuous"><parent link="base"/><child link="arm"/>
      <axis xyz="0 1 0"/></joint>)";
  const std::string tool = R"(<link name="tool"><inertial><origin xyz="0.03 0.01 -0.02"/>
      <mass value="0.7"/><inertia ixx="0.003" iyy="0.002" izz="0.004" ixy="0.0002" ixz="0.0001"
      iyz="-0.0003"/></inertial></link>
    <joint name="mount" type="fixed"><parent link="arm"/><child link="tool"/>
      <origin xyz="0.4 -0.1 0.2" rpy="0.3 -0.7 1.1"/></joint>)";
  const RobotModel with_tool = parse_urdf(head + tool + "</robot>", "tool");
  RobotModel bare = parse_urdf(head + "</robot>", "bare");
  Eigen::Matrix3d inertia;
  inertia << 0.003, 0.0002, 0.0001, 0.0002, 0.002, -0.0003, 0.0001, -0.0003, 0.004;
  add_payload(bare, with_tool.frames.back(), 0.7, {0.03, 0.01, -0.02}, inertia);
  EXPECT_TRUE(close(bare.pi, with_tool.pi, 1e-14));
  EXPECT_TRUE(is_physical(bare.pi.head<10>()));
}

// Of a payload at the flange, the torque is the Jacobian's transpose times its weight.
TEST(Payload, LoadsTheJointsWithItsWeight) {
  constexpr double kMass = 6, kStep = 1e-6;
  const RobotModel model = load("kr6_r700/kr6_r700.urdf");
  RobotModel loaded = model;
  const auto flange = std::find_if(model.frames.begin(), model.frames.end(),
                                   [](const Frame& f) { return f.name == "flange"; });
  add_payload(loaded, *flange, kMass, {0, 0, 0}, Eigen::Matrix3d::Zero());
  Robot plain(model), robot(loaded);
  const State s = random_state(model, 5);
  const VectorXd added = robot.gravity(s.q) - plain.gravity(s.q);
  for (int i = 0; i < model.n(); ++i) {
    const VectorXd step = kStep * VectorXd::Unit(model.n(), i);
    const double rise = (frame_pose(model, *flange, view(VectorXd(s.q + step))).p.z() -
                         frame_pose(model, *flange, view(VectorXd(s.q - step))).p.z()) /
                        (2 * kStep);
    EXPECT_NEAR(added(i), kMass * 9.81 * rise, 1e-7);
  }
}

TEST(Payload, OnTheBaseChangesNothing) {
  RobotModel model = load("test/pendulum.urdf");
  const VectorXd before = model.pi;
  add_payload(model, model.frames.front(), 5, {1, 0, 0}, Eigen::Matrix3d::Identity());
  EXPECT_EQ(model.pi, before);
}

}  // namespace
}  // namespace fricid::dynamics::test
