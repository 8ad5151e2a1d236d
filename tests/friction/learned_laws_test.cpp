// Laws with networks: what is left when the weights are zero, rates in closed form, starting
// weights, where sliding ends.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "fricid/friction/laws.hpp"
#include "fricid/friction/robot_friction.hpp"

namespace fricid::friction::test {
namespace {

// v over a few reversals, presliding to sliding [rad/s]
double speed(int k) { return 0.4 * std::sin(0.031 * k) * std::sin(0.0047 * k); }

TEST(Lvm, WithoutWeightsIsTwoDahlBristlesWithCoulombAndViscousFriction) {
  const RobotFriction lvm({{{{"lvm_bristles", 16, {}}}}});
  const RobotFriction laws({{{{"coulomb_viscous", 0, {}}, {"dahl", 0, {}}, {"dahl", 0, {}}}}});
  std::vector<double> theta = default_theta(lvm);
  const double F0 = 0.7, v0 = 0.03, Fv = 2.1, K1 = 3, K2 = 1.5, Delta1 = 1.3e-3, Delta2 = 4e-3;
  theta[Lvm::kF0] = F0;
  theta[Lvm::kV0] = v0;
  theta[Lvm::kFv] = Fv;
  theta[Lvm::K(0)] = K1;
  theta[Lvm::K(1)] = K2;
  theta[Lvm::delta(0)] = Delta1;
  theta[Lvm::delta(1)] = Delta2;
  const std::vector<double> expected_theta = {
      F0, Fv, v0, K1, K1 / Delta1, 0, K2, K2 / Delta2, 0};  // coulomb_viscous, dahl: Fc ..
  std::vector<double> s(2), z(2), tau(1), expected(1);
  for (int k = 0; k < 3000; ++k) {
    const Input<double> in{0, speed(k), 20, 300};
    lvm.torque<double>(theta, {&in, 1}, s, tau);
    laws.torque<double>(expected_theta, {&in, 1}, z, expected);
    ASSERT_NEAR(tau[0], expected[0], 1e-11) << k;
    lvm.step<double>(theta, {&in, 1}, 4e-3, s);
    laws.step<double>(expected_theta, {&in, 1}, 4e-3, z);
  }
}

TEST(Lvm, FallsExponentiallyTowardsTheInverseOfItsRate) {
  const Lvm law(16);
  std::vector<double> theta;
  for (const ParameterInfo& p : law.parameters()) theta.push_back(p.typical);
  const double r = 1.1;  // what the last network says: its output bias is the last weight
  theta.back() = r;
  const double rho = std::exp(3 * std::tanh(r / 3));
  for (const double v : {0.3, -0.3}) {
    const Input<double> in{0, v, 0, 300};
    std::vector<double> s = {0.2, -0.4};
    const double dt = 4e-3, E = std::exp(-rho * std::abs(v) * dt / theta[Lvm::delta(1)]);
    const double expected = E * s[1] + (1 - E) * std::copysign(1 / rho, v);
    law.step(theta.data(), in, dt, s.data());
    EXPECT_NEAR(s[1], expected, 1e-14);
    EXPECT_NEAR(
        law.steady_torque(theta.data(), in),
        std::copysign(theta[Lvm::kF0] * std::tanh(std::abs(v) / theta[Lvm::kV0]) +
                          theta[Lvm::kFv] * std::abs(v) + theta[Lvm::K(0)] + theta[Lvm::K(1)] / rho,
                      v),
        1e-12);
  }
}

// Networks as they start, with outputs 30 times as large so that they matter.
template <class Law>
std::vector<double> started(const Law& law, std::uint64_t seed) {
  std::vector<double> theta;
  for (const ParameterInfo& p : law.parameters()) theta.push_back(p.typical);
  Rng rng(seed, 0);
  law.initialise(theta.data(), rng);
  for (std::size_t i = Law::kCommon; i < theta.size(); ++i)
    if (std::abs(theta[i]) < 0.01) theta[i] *= 30;
  return theta;
}

TEST(Lvm, SlidingFromRestEndsAtTheSteadyTorque) {
  const Lvm law(16);
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    const std::vector<double> theta = started(law, seed);
    for (const double v : {0.02, -0.7}) {
      const Input<double> in{0, v, 35, 300};
      double s[2] = {};
      for (int k = 0; k < 4000; ++k) law.step(theta.data(), in, 3e-4 / std::abs(v), s);
      EXPECT_NEAR(law.torque(theta.data(), in, s), law.steady_torque(theta.data(), in), 1e-9);
      EXPECT_GT(std::abs(s[0] - std::copysign(1, v)), 1e-4) << "the rate is learned";
    }
  }
}

TEST(LearnedLaws, SeeTheSizeOfTheLoadAndNotItsSign) {
  const auto check = [](const auto& law) {
    const std::vector<double> theta = started(law, 5);
    const double z[4] = {0.3, -0.1, 0.5, 0.2};
    const auto torque = [&](double load) {
      return law.torque(theta.data(), Input<double>{0, 0.2, load, 300}, z);
    };
    EXPECT_EQ(torque(40), torque(-40));
    EXPECT_GT(std::abs(torque(40) - torque(10)), 1e-4);
  };
  check(Neural(16));
  check(Lvm1(16));
  check(Lvm(16));
  check(Lvm4(16));
}

TEST(LearnedLaws, StartCloseToTheirBackbone) {
  const auto check = [](const auto& law) {
    SCOPED_TRACE(law.kName);
    std::vector<double> plain;
    for (const ParameterInfo& p : law.parameters()) plain.push_back(p.typical);
    std::vector<double> theta = plain;
    Rng rng(1, 0);
    law.initialise(theta.data(), rng);
    EXPECT_TRUE(std::equal(theta.begin(), theta.begin() + law.kCommon, plain.begin()));
    double z[4] = {}, z_plain[4] = {}, largest = 0;
    for (int k = 0; k < 3000; ++k) {
      const Input<double> in{0, speed(k), 40, 300};
      const double off = law.torque(theta.data(), in, z) - law.torque(plain.data(), in, z_plain);
      largest = std::max(largest, std::abs(off));
      law.step(theta.data(), in, 4e-3, z);
      law.step(plain.data(), in, 4e-3, z_plain);
    }
    EXPECT_LT(largest, 0.05 * 5) << "of 5 N m";
    EXPECT_GT(largest, 0);
  };
  check(Neural(16));
  check(Lvm1(16));
  check(Lvm(16));
  check(Lvm4(16));
}

TEST(LearnedLaws, StartFromASeedEachJointAndLawByItself) {
  const JointSpec lvm{{{"lvm_bristles", 4, {}}}},
      both{{{"lvm_bristles", 4, {}}, {"lvm_bristles", 4, {}}}}, lugre{{{"lugre", 0, {}}}};
  const auto start = [](const std::vector<JointSpec>& joints, std::uint64_t seed) {
    const RobotFriction model(joints);
    std::vector<double> theta = default_theta(model);
    initialise_weights(model, seed, theta);
    return theta;
  };
  const auto tail = [](const std::vector<double>& x, std::size_t n) {
    return std::vector<double>(x.end() - static_cast<std::ptrdiff_t>(n), x.end());
  };
  const std::vector<double> two = start({lugre, lvm}, 3);
  const std::size_t n = two.size() - 6;
  EXPECT_EQ(tail(two, n), tail(start({both, lvm}, 3), n)) << "other joints do not matter";
  EXPECT_NE(tail(two, n), tail(start({lugre, lvm}, 4), n));
  EXPECT_NE(tail(two, n), start({lvm}, 3));
  const std::vector<double> doubled = start({both}, 3);
  EXPECT_NE(tail(doubled, n), std::vector<double>(doubled.begin(), doubled.end() - n));
  EXPECT_EQ(start({lugre}, 3), default_theta(RobotFriction({lugre})));
  EXPECT_TRUE(is_learned("lvm_bristles") && is_learned("neural"));
  EXPECT_FALSE(is_learned("lugre") || is_learned("gms"));
}

TEST(Neural, WithoutWeightsIsCoulombAndViscousFriction) {
  const RobotFriction neural({{{{"neural", 8, {}}}}});
  const RobotFriction law({{{{"coulomb_viscous", 0, {}}}}});
  const std::vector<double> theta = default_theta(neural);
  const std::vector<double> expected_theta = {theta[Neural::kFc], theta[Neural::kFv],
                                              theta[Neural::kV0]};
  std::vector<double> tau(1), expected(1);
  for (int k = 0; k < 300; ++k) {
    const Input<double> in{0, speed(10 * k), 20, 300};
    neural.torque<double>(theta, {&in, 1}, std::span<const double>{}, tau);
    law.torque<double>(expected_theta, {&in, 1}, std::span<const double>{}, expected);
    EXPECT_NEAR(tau[0], expected[0], 1e-13);
  }
}

}  // namespace
}  // namespace fricid::friction::test
