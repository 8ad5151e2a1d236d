// Reference: closed forms of the Dahl law, tau = Fc (1 - exp(-K x / Fc)) from rest.
#include "fricid/evaluate/characteristics.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace fricid::evaluate {
namespace {

constexpr double kFc = 5, kK = 1000, kFv = 0;

friction::Friction dahl_joint() {
  return {friction::RobotFriction({{{{"dahl", 0, {}}}}}), {kFc, kK, kFv}};
}

TEST(Characteristics, LengthOfPreslidingOfDahl) {
  // 90 % of Fc at x = Fc / K ln 10
  EXPECT_NEAR(presliding_length(dahl_joint())[0], kFc / kK * std::log(10), 2e-5);
}

TEST(Characteristics, TheOuterLoopReachesTheAmplitudeOnBothSidesAndIsLeftOnce) {
  const PreslidingMotion motion = presliding_motion(Eigen::VectorXd::Constant(1, 0.01));
  EXPECT_EQ(motion.q(0, 0), 0);
  EXPECT_NEAR(motion.q.maxCoeff(), 0.01, 1e-12);
  EXPECT_NEAR(motion.q.minCoeff(), -0.01, 1e-12);
  EXPECT_NEAR(motion.q(motion.q.rows() - 1, 0), 0.01, 1e-12);
  for (Eigen::Index k = 0; k + 1 < motion.q.rows(); ++k)
    EXPECT_NEAR(motion.q(k + 1, 0) - motion.q(k, 0), motion.v(k, 0) * motion.dt, 1e-9) << k;
}

TEST(Characteristics, DahlForgetsTheWayToTheOuterLoop) {
  const double amplitude = 5 * kFc / kK;
  const PreslidingMotion motion = presliding_motion(Eigen::VectorXd::Constant(1, amplitude));
  const RowMatrix tau = presliding_loop(dahl_joint(), motion);
  EXPECT_NEAR(tau.maxCoeff(), kFc, 0.01 * kFc);
  EXPECT_NEAR(tau.minCoeff(), -kFc, 0.01 * kFc);
}

TEST(Characteristics, TheLongestPreslidingSetsTheMotion) {
  friction::Friction longer = dahl_joint();
  longer.theta[0] *= 2;
  const PreslidingMotion motion = presliding_motion_through(std::vector{dahl_joint(), longer});
  EXPECT_NEAR(motion.q.maxCoeff(), 1.5 * presliding_length(longer)[0], 1e-12);
}

TEST(Characteristics, TheSlowestReversalIsNotOneOfAJointThatStopsThere) {
  constexpr double kDt = 0.01;
  Eigen::VectorXd v(600);  // a fast reversal, a slow one, and one without speed behind it
  for (int k = 0; k < v.size(); ++k) {
    const double t = k * kDt;
    v[k] = t < 2 ? 3 * (1.005 - t) : t < 4 ? 1.5 * (t - 3.005) : 0.3 * (5.005 - t);
  }
  EXPECT_EQ(slowest_reversal(v, kDt), 300);
  EXPECT_EQ(slowest_reversal(Eigen::VectorXd::Constant(100, 1), kDt), -1);
}

}  // namespace
}  // namespace fricid::evaluate
