// Hysteretic laws against closed forms of the literature and against fine explicit Euler.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <functional>
#include <numbers>
#include <vector>

#include "fricid/friction/laws.hpp"

namespace fricid::friction::test {
namespace {

Input<double> at_speed(double v) { return {0, v, 0, 293.15}; }

// Moves a law by `travel` at speed |v| in steps of dt.
template <class Law>
void move(const Law& law, const std::vector<double>& theta, double travel, double speed, double dt,
          std::vector<double>& z) {
  const double v = std::copysign(speed, travel);
  double left = std::abs(travel) / speed;
  for (; left > dt; left -= dt) law.step(theta.data(), at_speed(v), dt, z.data());
  law.step(theta.data(), at_speed(v), left, z.data());
}

template <class Law>
double torque(const Law& law, const std::vector<double>& theta, double v,
              const std::vector<double>& z) {
  return law.torque(theta.data(), at_speed(v), z.data());
}

// --- Dahl
// -----------------------------------------------------------------------------------------

TEST(Dahl, IsExponentialInTravelAtAnySpeed) {
  const std::vector<double> theta = {5, 12500, 0};  // Fc sigma0 Fv
  const double zc = theta[0] / theta[1];
  for (const double start : {-zc, 0.0, 0.5 * zc})
    for (const double travel : {1e-5, 4e-4, -4e-4, 3e-3})
      for (const double speed : {1e-4, 0.03, 20.0}) {
        std::vector<double> z = {start};
        move(Dahl{}, theta, travel, speed, 1e-3, z);
        const double end = std::copysign(zc, travel);
        EXPECT_NEAR(z[0], end + (start - end) * std::exp(-std::abs(travel) / zc), 1e-12 * zc);
      }
}

TEST(Dahl, ClosedLoopHasTheKnownArea) {
  // between turning points +-x the steady loop starts at -+z_t, z_t = zc tanh(x/zc), and its area
  // is 4 Fc (x - z_t)
  const std::vector<double> theta = {5, 12500, 0};
  const double zc = theta[0] / theta[1], x = 6e-4;
  std::vector<double> z = {0};
  for (int k = 0; k < 20; ++k) {
    move(Dahl{}, theta, 2 * x, 0.1, 1e-3, z);
    move(Dahl{}, theta, -2 * x, 0.1, 1e-3, z);
  }
  EXPECT_NEAR(z[0], -zc * std::tanh(x / zc), 1e-12 * zc);
  double area = 0;
  const int n = 20000;
  for (const double v : {0.1, -0.1})
    for (int k = 0; k < n; ++k) {
      const double dx = std::copysign(2 * x / n, v);
      const double before = torque(Dahl{}, theta, v, z);
      Dahl{}.step(theta.data(), at_speed(v), dx / v, z.data());
      area += 0.5 * (before + torque(Dahl{}, theta, v, z)) * dx;
    }
  EXPECT_NEAR(area, 4 * theta[0] * (x - zc * std::tanh(x / zc)), 1e-7 * area);
}

// --- LuGre
// ----------------------------------------------------------------------------------------

TEST(LuGre, FollowsItsExponentialAtConstantSpeed) {
  const std::vector<double> theta = {5,     6.5, 0.05,
                                     15000, 30,  2.5};  // Fc Fs vs sigma0 sigma1 sigma2
  for (const double v : {-0.4, -0.02, 1e-3, 0.05, 3.0}) {
    const double e = std::exp(-v * v / (0.05 * 0.05));
    const double g = 5 + 1.5 * e, r = 15000 * std::abs(v) / g;
    std::vector<double> z = {1e-4};
    double t = 0;
    for (const double dt : {1e-5, 3e-4, 4e-3, 0.05}) {
      LuGre{}.step(theta.data(), at_speed(v), dt, z.data());
      t += dt;
      const double expected = v / r + (1e-4 - v / r) * std::exp(-r * t);
      EXPECT_NEAR(z[0], expected, 1e-16);
      const double dz = v - r * expected;
      EXPECT_NEAR(torque(LuGre{}, theta, v, z), 15000 * expected + 30 * e * dz + 2.5 * v, 1e-10);
      EXPECT_NEAR(torque(LuGreClassic{}, theta, v, z), 15000 * expected + 30 * dz + 2.5 * v, 1e-10);
    }
  }
}

TEST(LuGre, ConstantDampingMakesEnergyWhereFadingDampingDoesNot) {
  // slowly the bristle loads to Fs; a jolt then releases it against sigma1 v, far above 4 g
  const std::vector<double> theta = {5, 6.5, 0.05, 15000, 30, 0};
  const auto work_of_a_cycle = [&](const auto& law) {
    const double travel = 2e-3;
    const int n = 20000;
    std::vector<double> z = {0};
    double work = 0;
    for (int cycle = 0; cycle < 2; ++cycle) {
      work = 0;
      for (const double v : {1e-3, 20.0, -1e-3, -20.0})
        for (int k = 0; k < n; ++k) {
          const double dt = travel / std::abs(v) / n;
          const double before = torque(law, theta, v, z);
          law.step(theta.data(), at_speed(v), dt, z.data());
          work += 0.5 * (before + torque(law, theta, v, z)) * v * dt;
        }
    }
    return work;
  };
  EXPECT_GT(work_of_a_cycle(LuGre{}), 0.03);
  EXPECT_LT(work_of_a_cycle(LuGreClassic{}), -0.03);
}

// --- Maxwell slip
// ---------------------------------------------------------------------------------

const MaxwellSlip kBank(4);
const std::vector<double> kBankTheta = {9000, 1.8, 4000, 1.6, 1500, 1.5, 400, 1.0};  // K W ...

double virgin_curve(double x) {
  double tau = 0;
  for (std::size_t i = 0; i < 8; i += 2) tau += std::min(kBankTheta[i] * x, kBankTheta[i + 1]);
  return tau;
}

TEST(MaxwellSlip, VirginCurveIsPiecewiseLinear) {
  for (const double x : {1e-5, 1.9e-4, 3e-4, 9e-4, 2e-3, 5e-3})
    for (const double dt : {1e-4, 1.0}) {
      std::vector<double> z(4);
      move(kBank, kBankTheta, x, 0.05, dt, z);
      EXPECT_NEAR(torque(kBank, kBankTheta, 0.05, z), virgin_curve(x), 1e-10);
    }
}

TEST(MaxwellSlip, ObeysMasing) {
  // after a reversal at x_r: tau_r - tau(x) = 2 f((x_r - x) / 2)
  const double x_r = 7e-4;
  for (const double back : {1e-5, 3e-4, 9e-4, 1.4e-3}) {
    std::vector<double> z(4);
    move(kBank, kBankTheta, x_r, 0.05, 1e-3, z);
    const double tau_r = torque(kBank, kBankTheta, 0, z);
    move(kBank, kBankTheta, -back, 0.05, 1e-3, z);
    EXPECT_NEAR(tau_r - torque(kBank, kBankTheta, 0, z), 2 * virgin_curve(back / 2), 1e-10);
  }
}

TEST(MaxwellSlip, RemembersReversalsNotLocally) {
  // a closed inner loop leaves no trace: back at its start, the outer branch goes on as if nothing
  // had been
  std::vector<double> z(4);
  move(kBank, kBankTheta, 1.5e-3, 0.05, 1e-3, z);
  move(kBank, kBankTheta, -1.1e-3, 0.05, 1e-3, z);
  std::vector<double> undisturbed = z;
  const double tau = torque(kBank, kBankTheta, 0, z);
  move(kBank, kBankTheta, 6e-4, 0.05, 1e-3, z);
  move(kBank, kBankTheta, -2e-4, 0.05, 1e-3, z);
  move(kBank, kBankTheta, 2e-4, 0.05, 1e-3, z);
  move(kBank, kBankTheta, -6e-4, 0.05, 1e-3, z);
  EXPECT_NEAR(torque(kBank, kBankTheta, 0, z), tau, 1e-10);
  move(kBank, kBankTheta, -2e-4, 0.05, 1e-3, z);
  move(kBank, kBankTheta, -2e-4, 0.05, 1e-3, undisturbed);
  for (std::size_t i = 0; i < 4; ++i) EXPECT_NEAR(z[i], undisturbed[i], 1e-15);
}

TEST(MaxwellSlip, EveryElementDissipates) {
  // what the joint puts into an element minus what its spring gains, for random steps
  std::vector<double> z(4);
  unsigned seed = 1;
  for (int n = 0; n < 100000; ++n) {
    seed = seed * 1664525u + 1013904223u;
    const double travel = (static_cast<double>(seed >> 8) / (1 << 24) - 0.5) * 4e-3;
    const std::vector<double> before = z;
    kBank.step(kBankTheta.data(), at_speed(travel), 1.0, z.data());
    for (std::size_t i = 0; i < 4; ++i) {
      const double K = kBankTheta[2 * i];
      const double stuck = z[i] - before[i];
      const double work = 0.5 * K * (before[i] + z[i]) * stuck + K * z[i] * (travel - stuck);
      const double gain = 0.5 * K * (z[i] * z[i] - before[i] * before[i]);
      ASSERT_GE(work - gain, -1e-12);
    }
  }
}

// --- Generalised Maxwell slip
// ---------------------------------------------------------------------

const Gms kGms(3);
// Fc Fs vs C Fv, then k alpha
const std::vector<double> kGmsTheta = {5, 7, 0.05, 200, 2, 9000, 0.4, 3000, 0.35, 900, 0.25};

double stribeck_level(double v) { return 5 + 2 * std::exp(-v * v / (0.05 * 0.05)); }

TEST(Gms, PreslidingIsAMaxwellSlipBankWithCapsAtFs) {
  // far below vs the caps are alpha_i Fs; rate independent
  const MaxwellSlip bank(3);
  const std::vector<double> bank_theta = {9000, 2.8, 3000, 2.45, 900, 1.75};
  std::vector<double> F(3), z(3);
  for (const double travel : {6e-4, -9e-4, 3e-4, -1e-4, 4e-3, -8e-3}) {
    move(kGms, kGmsTheta, travel, 1e-6, 1.0, F);
    move(bank, bank_theta, travel, 1e-6, 1.0, z);
    EXPECT_NEAR(torque(kGms, kGmsTheta, 0, F), torque(bank, bank_theta, 0, z), 1e-6);
  }
}

TEST(Gms, SlippingElementsAreAttractedToTheStribeckCurve) {
  std::vector<double> F(3);
  const double slow = 0.01, fast = 0.2;
  move(kGms, kGmsTheta, 0.5, slow, 1e-3, F);
  EXPECT_NEAR(torque(kGms, kGmsTheta, slow, F), stribeck_level(slow) + 2 * slow, 1e-10);
  double t = 0;
  for (int k = 0; k < 50; ++k) {
    kGms.step(kGmsTheta.data(), at_speed(fast), 1e-3, F.data());
    t += 1e-3;
    const double s = stribeck_level(fast);
    EXPECT_NEAR(torque(kGms, kGmsTheta, fast, F),
                s + (stribeck_level(slow) - s) * std::exp(-200 * t / s) + 2 * fast, 1e-10);
  }
}

TEST(Gms, LagsBehindTheStribeckCurve) {
  // at the same speed friction is larger while speeding up than while slowing down
  std::vector<double> F(3);
  const double period = 0.2, dt = 1e-4;
  const auto v_at = [&](double t) {
    return 0.06 - 0.05 * std::cos(2 * std::numbers::pi * t / period);
  };
  double rising = 0, falling = 0;  // torque where v passes 0.06
  for (int k = 0; k < 4000; ++k) {
    const double t = k * dt;
    kGms.step(kGmsTheta.data(), at_speed(v_at(t + dt / 2)), dt, F.data());
    if (k == 2500) rising = torque(kGms, kGmsTheta, 0, F);
    if (k == 3500) falling = torque(kGms, kGmsTheta, 0, F);
  }
  EXPECT_NEAR(v_at(0.25), v_at(0.35), 1e-15);
  EXPECT_GT(rising, stribeck_level(0.06));
  EXPECT_GT(rising, falling + 0.2);
}

TEST(Gms, AReversalSticksEvenWhereTheCapHasFallen) {
  // sliding slowly at Fs, then suddenly fast the other way, where the cap is lower: the elements
  // unload through their springs, k v, and do not slip although |F| > cap
  std::vector<double> F(3);
  move(kGms, kGmsTheta, 0.5, 1e-4, 1e-2, F);
  const std::vector<double> before = F;
  const double v = -0.5, dt = 1e-5;
  ASSERT_GT(F[0], 0.4 * stribeck_level(v));
  kGms.step(kGmsTheta.data(), at_speed(v), dt, F.data());
  for (std::size_t i = 0; i < 3; ++i)
    EXPECT_NEAR(F[i], before[i] + kGmsTheta[5 + 2 * i] * v * dt, 1e-12);
}

TEST(Gms, OnlyRatiosOfAlphaCount) {
  std::vector<double> scaled = kGmsTheta;
  for (const std::size_t i : {6u, 8u, 10u}) scaled[i] *= 8;
  std::vector<double> F = {0.3, -0.8, 1.1}, G = F;
  for (const double v : {0.1, -0.03, 0.4}) {
    kGms.step(kGmsTheta.data(), at_speed(v), 4e-3, F.data());
    kGms.step(scaled.data(), at_speed(v), 4e-3, G.data());
  }
  for (std::size_t i = 0; i < 3; ++i) EXPECT_DOUBLE_EQ(F[i], G[i]);
}

// --- all: the limit dt -> 0
// -----------------------------------------------------------------------

using Rate = std::function<double(double v, double z)>;

// Largest difference between law and explicit Euler over one period of a smooth velocity, relative
// to the largest state; both take the same n steps.
template <class Law>
double difference_from_euler(const Law& law, const std::vector<double>& theta,
                             const std::vector<Rate>& rates, int n) {
  std::vector<double> z(rates.size()), euler(rates.size());
  double largest = 0, difference = 0;
  const double period = 0.5;
  for (int k = 0; k < n; ++k) {
    const double t = period * k / n, dt = period / n;
    const double v = 0.08 * std::sin(2 * std::numbers::pi * t / period) +
                     0.03 * std::sin(6 * std::numbers::pi * t / period + 1);
    law.step(theta.data(), at_speed(v), dt, z.data());
    for (std::size_t i = 0; i < rates.size(); ++i) {
      euler[i] += rates[i](v, euler[i]) * dt;
      largest = std::max(largest, std::abs(z[i]));
      difference = std::max(difference, std::abs(z[i] - euler[i]));
    }
  }
  return difference / largest;
}

template <class Law>
void expect_euler_limit(const Law& law, const std::vector<double>& theta,
                        const std::vector<Rate>& rates) {
  const double coarse = difference_from_euler(law, theta, rates, 50000);
  const double fine = difference_from_euler(law, theta, rates, 200000);
  EXPECT_LT(coarse, 0.05);
  EXPECT_LT(fine, 0.35 * coarse) << "first order: a quarter of the step, a quarter of the error";
}

TEST(SmallStepLimit, Dahl) {
  expect_euler_limit(Dahl{}, {5, 12500, 1},
                     {[](double v, double z) { return v - 12500 * std::abs(v) * z / 5; }});
}

TEST(SmallStepLimit, LuGre) {
  expect_euler_limit(LuGre{}, {5, 6.5, 0.05, 15000, 30, 2.5}, {[](double v, double z) {
                       const double g = 5 + 1.5 * std::exp(-std::pow(v / 0.05, 2));
                       return v - 15000 * std::abs(v) * z / g;
                     }});
}

TEST(SmallStepLimit, MaxwellSlip) {
  std::vector<Rate> rates;
  for (std::size_t i = 0; i < 4; ++i)
    rates.push_back([i](double v, double z) {
      const double cap = kBankTheta[2 * i + 1] / kBankTheta[2 * i];
      return (v > 0 && z >= cap) || (v < 0 && z <= -cap) ? 0.0 : v;
    });
  expect_euler_limit(kBank, kBankTheta, rates);
}

TEST(SmallStepLimit, Gms) {
  std::vector<Rate> rates;
  for (std::size_t i = 0; i < 3; ++i)
    rates.push_back([i](double v, double F) {
      const double s = stribeck_level(v), share = kGmsTheta[6 + 2 * i];
      const double direction = v < 0 ? -1 : 1;
      return direction * F < share * s ? kGmsTheta[5 + 2 * i] * v
                                       : direction * 200 * (share - direction * F / s);
    });
  expect_euler_limit(kGms, kGmsTheta, rates);
}

}  // namespace
}  // namespace fricid::friction::test
