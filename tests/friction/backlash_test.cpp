// Backlash in series with a law, against the closed form of a play in series with a spring that
// slips.
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "fricid/friction/robot_friction.hpp"

namespace fricid::friction::test {
namespace {

constexpr double K = 2000, W = 3, b = 5e-4;  // the element gives way at 1.5 mrad

struct Joint {
  RobotFriction model{{{{{"maxwell_slip", 1, {{"backlash"}}}}}}};
  std::vector<double> theta = {K, W, b};
  std::vector<double> z = {0, 0};  // spring, gap

  double move(double travel, double step) {
    const double v = std::copysign(0.1, travel);
    const double dt = step / 0.1;
    for (double left = std::abs(travel); left > 1e-12; left -= step) {
      const Input<double> in{0, v, 0, 300};
      model.step<double>(theta, {&in, 1}, std::min(step, left) / step * dt, z);
    }
    return torque(v);
  }
  double torque(double v) const {
    const Input<double> in{0, v, 0, 300};
    double tau = 0;
    model.torque<double>(theta, {&in, 1}, z, {&tau, 1});
    return tau;
  }
};

TEST(Backlash, CrossesTheGapLoadsSlipsUnloadsAndCrossesBack) {
  // coarse steps jump over several of these events at once
  for (const double step : {1e-6, 3.7e-4, 1.1e-3}) {
    SCOPED_TRACE(step);
    Joint joint;
    EXPECT_NEAR(joint.move(0.4e-3, step), 0, 1e-12);          // in the gap
    EXPECT_NEAR(joint.move(0.6e-3, step), K * 0.5e-3, 1e-9);  // contact at b
    EXPECT_NEAR(joint.move(2.0e-3, step), W, 1e-9);           // slips
    EXPECT_NEAR(joint.move(-1.0e-3, step), W - 2, 1e-9);      // unloads first
    EXPECT_NEAR(joint.move(-0.5e-3, step), 0, 1e-9);          // stored torque is gone: gap
    EXPECT_NEAR(joint.z[1], b, 1e-9);
    EXPECT_NEAR(joint.move(-0.4e-3, step), 0, 1e-9);
    EXPECT_NEAR(joint.move(-0.6e-3 - 0.7e-3, step), -K * 0.7e-3, 1e-9);  // contact at -b, loads
    EXPECT_NEAR(joint.z[1], -b, 1e-12);
  }
}

TEST(Backlash, GapAndLawShareTheMotion) {
  // q = law + gap, whatever the steps, as long as the spring holds
  Joint joint;
  joint.theta[1] = 1e3;
  double q = 0;
  unsigned seed = 7;
  for (int n = 0; n < 20000; ++n) {
    seed = seed * 1664525u + 1013904223u;
    const double travel = (static_cast<double>(seed >> 8) / (1 << 24) - 0.5) * 1e-3;
    q += travel;
    const Input<double> in{0, travel / 1e-3, 0, 300};
    joint.model.step<double>(joint.theta, {&in, 1}, 1e-3, joint.z);
    ASSERT_NEAR(joint.z[0] + joint.z[1], q, 1e-12);
    ASSERT_LE(std::abs(joint.z[1]), b);
    // a loaded spring has closed the gap on its side
    if (std::abs(joint.z[0]) < 1e-9) continue;
    ASSERT_NEAR(joint.z[1], std::copysign(b, joint.z[0]), 1e-12);
  }
}

TEST(Backlash, EntersTheGapWithAStoredTorqueOfSecondOrder) {
  // Dahl's unloading is curved, so the secant misses tau_0 = 0 by O(dt^2)
  const RobotFriction model{{{{{"dahl", 0, {{"backlash"}}}}}}};
  const std::vector<double> theta = {5, 12500, 0, 1e-2};
  const auto left_over = [&](double dt) {
    std::vector<double> z = {theta[0] / theta[1], theta[3]};
    const Input<double> in{0, -0.05, 0, 300};
    while (z[1] == theta[3]) model.step<double>(theta, {&in, 1}, dt, z);
    return std::abs(z[0]) * theta[1] / theta[0];
  };
  double coarse = 0, fine = 0;  // worst over where the step falls
  for (int k = 0; k < 40; ++k) {
    coarse = std::max(coarse, left_over(1e-3 * (1 + 0.01 * k)));
    fine = std::max(fine, left_over(0.25e-3 * (1 + 0.01 * k)));
  }
  EXPECT_LT(coarse, 0.02);
  EXPECT_LT(fine, coarse / 8);
}

TEST(Backlash, SilencesALawThatHasUnloaded) {
  // the stored torque is near zero and of either sign: whether there is viscous torque must not
  // depend on it
  const RobotFriction model{{{{{"gms", 4, {{"backlash"}}}}}}};
  const std::vector<double> theta = default_theta(model);
  const double gap = theta.back();
  const auto torque = [&](double v, const std::vector<double>& z) {
    const Input<double> in{0, v, 0, 300};
    double tau = 0;
    model.torque<double>(theta, {&in, 1}, z, {&tau, 1});
    return tau;
  };
  int silent = 0;
  for (int phase = 0; phase < 20; ++phase) {
    std::vector<double> z(static_cast<std::size_t>(model.state_size()));
    for (int k = 0; k < 4000; ++k) {
      const double v = 0.03 * std::sin(1e-3 * k * (4 + 0.1 * phase));
      const Input<double> in{0, v, 0, 300};
      model.step<double>(theta, {&in, 1}, 1e-3, z);
      if (std::abs(z.back()) == gap) continue;
      ASSERT_EQ(torque(v, z), torque(0, z)) << phase << ", " << k;
      ++silent;
    }
  }
  EXPECT_GT(silent, 100);
}

TEST(Backlash, SilencesALawWithoutStateInTheGap) {
  const RobotFriction model{{{{{"coulomb_viscous", 0, {{"backlash"}}}}}}};
  const std::vector<double> theta = {5, 2, 0.01, b};
  std::vector<double> z = {-b}, tau(1);
  const auto torque = [&](double v) {
    const Input<double> in{0, v, 0, 300};
    model.torque<double>(theta, {&in, 1}, z, tau);
    return tau[0];
  };
  EXPECT_EQ(torque(1.0), 0);
  EXPECT_NEAR(torque(-1.0), -7, 1e-12);
  const Input<double> in{0, 1, 0, 300};
  model.step<double>(theta, {&in, 1}, 2 * b, z);
  EXPECT_NEAR(torque(1.0), 7, 1e-12);
}

}  // namespace
}  // namespace fricid::friction::test
