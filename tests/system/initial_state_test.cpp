#include "fricid/system/initial_state.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "kr6_truth.hpp"

namespace fricid::test {
namespace {

using Inputs = std::vector<friction::Input<double>>;

Inputs at_rest() { return Inputs(6, friction::Input<double>{0.2, 0, 0, kRoomTemperature}); }

std::vector<double> torque(const friction::Friction& friction, const Inputs& in,
                           const std::vector<double>& z) {
  std::vector<double> tau_f(in.size());
  friction.model.torque<double>(friction.theta, in, z, tau_f);
  return tau_f;
}

class InitialState : public ::testing::TestWithParam<const char*> {
 protected:
  friction::Friction friction = kr6_friction(GetParam());

  /// State after sliding at `speed` in the directions of `sign`.
  std::vector<double> slid(const std::vector<double>& sign, double speed, double period = 0.004) {
    std::vector<double> z(static_cast<std::size_t>(friction.model.state_size()));
    Inputs in = at_rest();
    for (std::size_t j = 0; j < in.size(); ++j) in[j].v = sign[j] * speed;
    for (int k = 0; k < 2000; ++k) friction.model.step<double>(friction.theta, in, period, z);
    return z;
  }
};
INSTANTIATE_TEST_SUITE_P(Laws, InitialState,
                         ::testing::Values("dahl", "lugre", "gms", "maxwell_slip"));

// Any torque that rest can hold is met, and the state is one that motion leads to: driven on, it
// slides like any other.
TEST_P(InitialState, HasTheTorque) {
  const std::vector<double> all = torque(friction, at_rest(), slid({1, 1, 1, 1, 1, 1}, 0.02));
  std::vector<double> wanted(6);
  const double share[6] = {0.9, -0.9, 0.3, -0.05, 0.6, 0};
  for (std::size_t j = 0; j < 6; ++j) wanted[j] = share[j] * all[j];
  const std::vector<double> z = state_at_torque(friction, at_rest(), wanted);
  const std::vector<double> found = torque(friction, at_rest(), z);
  for (std::size_t j = 0; j < 6; ++j)
    EXPECT_NEAR(found[j], wanted[j], 0.01 * all[j]) << "joint " << j + 1;
}

TEST_P(InitialState, OfAJointThatStoppedIsItsSlidingState) {
  const std::vector<double> z = slid({1, -1, 1, -1, 1, -1}, 0.02);
  const std::vector<double> found =
      state_at_torque(friction, at_rest(), torque(friction, at_rest(), z));
  for (std::size_t i = 0; i < z.size(); ++i)
    EXPECT_NEAR(found[i], z[i], 2e-3 * std::abs(z[i])) << "state " << i;
}

TEST_P(InitialState, OfAMovingJointIsThatOfItsSpeed) {
  const std::vector<double> z = slid({1, -1, 1, -1, 1, -1}, 0.5);
  Inputs in = at_rest();
  for (std::size_t j = 0; j < 6; ++j) in[j].v = j % 2 == 0 ? 0.5 : -0.5;
  const std::vector<double> found = state_at_torque(friction, in, std::vector<double>(6, 0.0));
  for (std::size_t i = 0; i < z.size(); ++i)
    EXPECT_NEAR(found[i], z[i], 1e-6 * std::abs(z[i])) << "state " << i;
}

// A torque that no rest explains gets the nearest one: static friction.
TEST_P(InitialState, CreepsBeyondItsTorque) {
  const std::vector<double> z = slid({1, 1, 1, 1, 1, 1}, 2e-4, 0.2);
  const std::vector<double> found =
      state_at_torque(friction, at_rest(), std::vector<double>(6, 1e3));
  for (std::size_t i = 0; i < z.size(); ++i)
    EXPECT_NEAR(found[i], z[i], 2e-3 * std::abs(z[i])) << "state " << i;
}

// Rest may hold more than a short slide bends a cable to.
TEST(StateAtTorque, BendsCables) {
  const friction::Friction friction{
      friction::RobotFriction(std::vector<friction::JointSpec>(
          1, friction::JointSpec{{{"lugre", 0, {}}, {"maxwell_slip", 1, {}}}})),
      {2.6, 3, 0.07, 4900, 5, 1.1, 2.2, 1.2}};
  const Inputs in(1, friction::Input<double>{0.2, 0, 0, kRoomTemperature});
  for (const double wanted : {4.0, -4.0, 2.0}) {
    const std::vector<double> z = state_at_torque(friction, in, std::vector<double>{wanted});
    EXPECT_NEAR(torque(friction, in, z).front(), wanted, 0.01 * std::abs(wanted));
  }
}

// The rest of the torque balance is the rigid body's.
TEST(InitialFrictionState, TakesWhatTheRigidBodyLeaves) {
  const Arm arm{hanging_kr6(), kr6_friction("dahl")};
  const RowMatrix q = RowMatrix::Constant(50, 6, 0.3), v = RowMatrix::Zero(50, 6);
  dynamics::Workspace<double> ws(arm.robot);
  std::vector<double> gravity(6);
  const std::span<const double> pi(arm.robot.pi.data(),
                                   static_cast<std::size_t>(arm.robot.pi.size()));
  const std::vector<double> at(6, 0.3), still(6, 0.0);
  dynamics::rnea<double>(arm.robot, ws, pi, at, still, still, gravity);
  RowMatrix tau(50, 6);
  for (int j = 0; j < 6; ++j) tau.col(j).setConstant(gravity[static_cast<std::size_t>(j)] + 0.5);
  const std::vector<double> z = initial_friction_state(arm, 0.004, q, v, tau, RowMatrix());
  for (const double tau_f : torque(arm.friction, at_rest(), z)) EXPECT_NEAR(tau_f, 0.5, 5e-3);
}

}  // namespace
}  // namespace fricid::test
