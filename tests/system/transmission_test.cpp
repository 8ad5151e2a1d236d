#include "fricid/system/transmission.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace fricid::test {
namespace {

dynamics::RobotModel three_joints() {
  dynamics::RobotModel robot;
  robot.joints.resize(3);
  return robot;
}

TEST(Transmission, LeavesSignalsOfSingleMotorsAsTheyAre) {
  const Transmission motors(three_joints());
  const RowMatrix x = RowMatrix::Random(4, 3);
  EXPECT_FALSE(motors.coupled());
  EXPECT_EQ(motors.to_motors(x), x);
  EXPECT_EQ(motors.torque_to_joints(x), x);
}

// Laws: there and back is the same, and the power of the motors is that of the joints.
TEST(Transmission, KeepsPower) {
  dynamics::RobotModel robot = three_joints();
  robot.couplings = {{2, 1, -1}, {1, 0, 0.5}};
  const Transmission motors(robot);
  const RowMatrix q = RowMatrix::Random(5, 3), tau = RowMatrix::Random(5, 3);
  const RowMatrix m = motors.to_motors(q), tau_m = motors.torque_to_motors(tau);
  EXPECT_LT((motors.to_joints(m) - q).norm(), 1e-14);
  EXPECT_LT((motors.torque_to_joints(tau_m) - tau).norm(), 1e-14);
  EXPECT_LT((q.cwiseProduct(tau).rowwise().sum() - m.cwiseProduct(tau_m).rowwise().sum()).norm(),
            1e-14);
  // m1 = q1, m2 = q2 - m1 / 2, m3 = q3 + m2
  EXPECT_DOUBLE_EQ(m(0, 1), q(0, 1) - q(0, 0) / 2);
  EXPECT_DOUBLE_EQ(m(0, 2), q(0, 2) + q(0, 1) - q(0, 0) / 2);
}

TEST(Transmission, AMissingValueSpoilsOnlyWhatDependsOnIt) {
  dynamics::RobotModel robot = three_joints();
  robot.couplings = {{2, 1, -1}};
  signals::Dataset log;
  log.q = RowMatrix::Ones(2, 3);
  log.tau = log.q;
  log.q(0, 1) = log.tau(1, 2) = std::numeric_limits<double>::quiet_NaN();
  const signals::Dataset at_motors = Transmission(robot).to_motors(log);
  EXPECT_EQ(at_motors.q(0, 0), 1);
  EXPECT_TRUE(std::isnan(at_motors.q(0, 1)));
  EXPECT_TRUE(std::isnan(at_motors.q(0, 2)));
  EXPECT_EQ(at_motors.q(1, 2), 2);
  EXPECT_EQ(at_motors.tau(1, 0), 1);
  EXPECT_TRUE(std::isnan(at_motors.tau(1, 1)));
  EXPECT_EQ(at_motors.v.size(), 0);
}

}  // namespace
}  // namespace fricid::test
