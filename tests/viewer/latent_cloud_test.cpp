#include "fricid/viewer/latent_cloud.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace fricid::viewer {
namespace {

constexpr int kRows = 1001, kCopies = 50;
constexpr double kDt = 0.002;

/// Dahl's bristle, turned to and fro: Fc = 10 N m, sigma0 = 5000 N m/rad, no viscosity.
class LatentCloudTest : public ::testing::Test {
 protected:
  static constexpr double kBristle = 10.0 / 5000;  // [rad]
  friction::Friction friction{
      friction::RobotFriction(std::vector<friction::JointSpec>{{{{"dahl", 0, {}}}}}),
      {10, 5000, 0}};

  JointMotion motion(double amplitude) const {
    JointMotion m{kDt, RowMatrix(kRows, 1), RowMatrix(kRows, 1), RowMatrix::Zero(kRows, 1), {}, {}};
    for (int k = 0; k < kRows; ++k) {
      const double w = 2 * 3.141592653589793, t = k * kDt;
      m.q(k, 0) = amplitude * std::sin(w * t);
      m.v(k, 0) = amplitude * w * std::cos(w * t);
    }
    m.z = drive_friction(friction, kDt, m.q, m.v, m.load, m.temperature).z;
    return m;
  }
};

// Reference: the difference of two of Dahl's states falls by exp(-travel / bristle length).
TEST_F(LatentCloudTest, TravelIsWhatForgets) {
  const JointMotion m = motion(0.01);
  for (const int row : {300, 625, 750}) {
    SCOPED_TRACE(row);
    const int samples = 20;
    const LatentCloud cloud = latent_cloud(friction, m, row, samples * kDt, kCopies);
    double travel = 0;
    for (int k = row - samples; k < row; ++k) travel += std::abs(m.q(k + 1, 0) - m.q(k, 0));
    ASSERT_GT(spread(cloud.from_tau), 1);
    EXPECT_NEAR(spread(cloud.tau) / spread(cloud.from_tau), std::exp(-travel / kBristle), 1e-9);
    EXPECT_NEAR(
        cloud.tau.mean() - cloud.state_tau,
        (cloud.from_tau.mean() - 5000 * m.z(row - samples, 0)) * std::exp(-travel / kBristle),
        1e-9);
  }
}

TEST_F(LatentCloudTest, AJointAtRestForgetsNothing) {
  JointMotion still = motion(0.01);
  still.q.setZero();
  still.v.setZero();
  const LatentCloud cloud = latent_cloud(friction, still, kRows - 1, 1, kCopies);
  EXPECT_GT(spread(cloud.tau), 1);
  EXPECT_EQ(cloud.tau, cloud.from_tau);
  EXPECT_EQ(cloud.to, cloud.from);
}

TEST_F(LatentCloudTest, CopiesBeginInStatesOfTheMotion) {
  const JointMotion m = motion(0.01);
  const LatentCloud cloud = latent_cloud(friction, m, 400, 0, kCopies);
  EXPECT_EQ(cloud.from.rows(), kCopies);
  EXPECT_EQ(cloud.to, cloud.from);
  for (Eigen::Index i = 0; i < kCopies; ++i)
    EXPECT_TRUE((m.z.array() == cloud.from(i, 0)).any()) << i;
}

TEST_F(LatentCloudTest, AgeEndsWhereTheMotionBegins) {
  const JointMotion m = motion(0.01);
  EXPECT_EQ(latent_cloud(friction, m, 5, 9, kCopies).to,
            latent_cloud(friction, m, 5, 5 * kDt, kCopies).to);
}

}  // namespace
}  // namespace fricid::viewer
