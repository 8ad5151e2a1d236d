// Laws without state and modifiers against the formulas they stand for.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <vector>

#include "fricid/friction/laws.hpp"

namespace fricid::friction::test {
namespace {

template <class Law>
double torque(const Law& law, const std::vector<double>& theta, double v, double load = 0) {
  return law.torque(theta.data(), Input<double>{0, v, load, 293.15},
                    static_cast<const double*>(nullptr));
}

TEST(CoulombViscous, IsCoulombPlusViscousAboveTheSmoothingSpeed) {
  const std::vector<double> theta = {4, 2.5, 0.01};
  for (const double v : {0.3, -0.3, 2.0})
    EXPECT_NEAR(torque(CoulombViscous{}, theta, v), std::copysign(4, v) + 2.5 * v, 1e-12);
  EXPECT_NEAR(torque(CoulombViscous{}, theta, 0.01), 4 * std::tanh(1) + 0.025, 1e-14);
}

TEST(CoulombViscous, SettlesOrChattersAsTheRuleSays) {
  // semi-implicit Euler of M a = -tau_f; the rule is Fc dt / (M v0) < 2
  const auto speed_after = [](double rule) {
    const double M = 0.5, Fc = 5, dt = 5e-4, v0 = Fc * dt / (M * rule);
    const std::vector<double> theta = {Fc, 0, v0};
    double v = 0.3 * v0;
    for (int k = 0; k < 2000; ++k) v -= dt / M * torque(CoulombViscous{}, theta, v);
    return std::abs(v) / v0;
  };
  EXPECT_LT(speed_after(0.5), 1e-9);
  EXPECT_LT(speed_after(1.9), 1e-9);
  EXPECT_GT(speed_after(2.5), 0.1);
}

TEST(Stribeck, FallsFromStaticToCoulomb) {
  const std::vector<double> theta = {5, 6.5, 0.05, 2, 1e-4};
  for (const double v : {0.01, 0.05, -0.08, 1.0})
    EXPECT_NEAR(torque(Stribeck{}, theta, v),
                std::copysign(5 + 1.5 * std::exp(-std::pow(v / 0.05, 2)), v) + 2 * v, 1e-12);
}

TEST(StribeckPeak, IsWhatStribeckLosesWithSpeed) {
  for (const double v : {0.001, 0.01, 0.05, -0.08, 1.0})
    EXPECT_NEAR(
        torque(StribeckPeak{}, {1.5, 0.05, 0.01}, v),
        torque(Stribeck{}, {5, 6.5, 0.05, 0, 0.01}, v) - torque(CoulombViscous{}, {5, 0, 0.01}, v),
        1e-12);
}

TEST(ViscousPower, IsThePowerAboveAndLinearBelowItsSmoothingSpeed) {
  const std::vector<double> theta = {3, 0.8, 1e-4};
  for (const double v : {0.1, -0.7, 5.0})
    EXPECT_NEAR(torque(ViscousPower{}, theta, v), std::copysign(3 * std::pow(std::abs(v), 0.8), v),
                1e-5);
  EXPECT_NEAR(torque(ViscousPower{}, theta, 1e-7) / 1e-7, 3 * std::pow(1e-4, -0.2), 1e-4);
  EXPECT_DOUBLE_EQ(torque(ViscousPower{}, {3, 1, 0.01}, 0.7), 3 * 0.7);
}

TEST(LoadDependent, GrowsWithLoadByDirectionOfPowerFlow) {
  // Fc mu_m mu_b nu_m nu_b Fv v0 l0
  const std::vector<double> theta = {4, 0.06, 0.03, 1e-3, 2e-4, 2, 1e-3, 1e-6};
  for (const double load : {30.0, -30.0})
    for (const double v : {0.5, -0.5}) {
      const bool motoring = load * v > 0;
      const double level = 4 + (motoring ? 0.06 : 0.03) * 30 + (motoring ? 1e-3 : 2e-4) * 900;
      EXPECT_NEAR(torque(LoadDependent{}, theta, v, load), std::copysign(level, v) + 2 * v, 1e-5);
    }
  EXPECT_NEAR(torque(LoadDependent{}, theta, 0.5, 0), 4 + 1, 1e-12);
}

TEST(LoadDependent, IsSmoothThroughZeroLoadAndZeroSpeed) {
  const std::vector<double> theta = {4, 0.06, 0.03, 1e-3, 2e-4, 2, 0.01, 0.5};
  const double h = 1e-4;
  for (const double v : {-1e-3, 0.0, 1e-3})
    for (const double load : {-0.1, 0.0, 0.1}) {
      const double dv2 = torque(LoadDependent{}, theta, v + h, load) -
                         2 * torque(LoadDependent{}, theta, v, load) +
                         torque(LoadDependent{}, theta, v - h, load);
      const double dl2 = torque(LoadDependent{}, theta, v, load + h) -
                         2 * torque(LoadDependent{}, theta, v, load) +
                         torque(LoadDependent{}, theta, v, load - h);
      EXPECT_LT(std::abs(dv2), 5 / (0.01 * 0.01) * h * h);
      EXPECT_LT(std::abs(dl2), 0.1 / 0.5 * h * h);
    }
}

TEST(Asymmetry, IsContinuousWhereTheTorquePassesZero) {
  const Input<double> in{0, -1, 0, 293.15};  // v < 0 while the torque falls through 0
  const double a = 0.2;
  const double above = Asymmetry{}.apply(&a, in, 1e-9), below = Asymmetry{}.apply(&a, in, -1e-9);
  EXPECT_LT(above - below, 3e-9);
  EXPECT_DOUBLE_EQ(Asymmetry{}.apply(&a, in, 5.0), 6.0);
  EXPECT_DOUBLE_EQ(Asymmetry{}.apply(&a, in, -5.0), -4.0);
}

}  // namespace
}  // namespace fricid::friction::test
