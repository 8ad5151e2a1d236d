// Friction that goes with another joint's speed: found where the motion shows it, and not claimed
// where two joints only ever turn together.
#include "fricid/estimate/couplings.hpp"

#include <gmock/gmock.h>

#include <array>
#include <cmath>
#include <span>

#include "fricid/base/rng.hpp"

namespace fricid::estimate {
namespace {

constexpr int kLength = 1500;
constexpr double kStep = 0.01;  // [s]

/// Two joints with these speeds, and their torques beside noise.
template <class Speeds, class Torque>
signals::Recording recording(const Speeds& speeds, const Torque& torque) {
  signals::Recording r;
  r.dt = kStep;
  r.held_tau.setZero(kLength, 2);
  r.wide.v.resize(kLength, 2);
  r.filtered_tau.resize(kLength, 2);
  r.use.setConstant(kLength, 2, true);
  Rng rng(3, 0);
  for (int k = 0; k < kLength; ++k) {
    const std::array<double, 2> v = speeds(k * kStep);
    r.wide.v.row(k) << v[0], v[1];
    const std::array<double, 2> tau = torque(k * kStep, v);
    r.filtered_tau.row(k) << tau[0] + 0.3 * rng.normal(), tau[1] + rng.normal();
  }
  return r;
}

template <class Speeds, class Torque>
std::vector<Coupling> couplings(const Speeds& speeds, const Torque& torque) {
  const signals::Recording r = recording(speeds, torque);
  const FrictionTorques target{r.filtered_tau};
  return find_couplings(std::span(&r, 1), target);
}

/// The recording with its joints in the other order.
signals::Recording swapped(signals::Recording r) {
  for (RowMatrix* signal : {&r.wide.v, &r.filtered_tau}) signal->col(0).swap(signal->col(1));
  return r;
}

double sign(double x) { return x > 0 ? 1 : -1; }

TEST(Couplings, FrictionOfAMotorBetweenTwoJointsIsFound) {
  const auto apart = [](double t) {
    return std::array{std::sin(1.3 * t), 0.8 * std::sin(2.1 * t + 1)};
  };
  for (const double factor : {1.0, -1.0, 0.6, -2.5}) {
    const std::vector<Coupling> found =
        couplings(apart, [&](double, const std::array<double, 2>& v) {
          const double of_motor = 3 * sign(v[0] + factor * v[1]);
          return std::array{2 * sign(v[0]) + of_motor, factor * of_motor};
        });
    EXPECT_EQ(found[0].with, 1);
    EXPECT_NEAR(found[0].factor / factor, 1, std::abs(factor) == 1 ? 0 : 0.05) << factor;
    EXPECT_NEAR(declared_factor(found[0], 0), -1 / found[0].factor,
                1e-12);  // of joint 1, the outer
    EXPECT_GT(found[0].share, 0.9);
    EXPECT_TRUE(matters(found[0], found[0].r2));
  }
}

// Friction of the outer joint goes with the motor's speed alone, or with its own beside it, which a
// declared coupling would lose.
TEST(Couplings, ThatLeaveFrictionAtTheJointAreNotDeclared) {
  dynamics::RobotModel robot;
  for (const char* name : {"inner", "outer"}) {
    robot.joints.emplace_back();
    robot.joints.back().name = name;
  }
  const auto apart = [](double t) {  // the outer joint first
    return std::array{0.8 * std::sin(2.1 * t + 1), std::sin(1.3 * t)};
  };
  for (const bool own : {false, true}) {
    signals::Recording r = swapped(recording(apart, [&](double, const std::array<double, 2>& v) {
      const double of_motor = 3 * sign(v[0] + v[1]);
      return std::array{of_motor + (own ? 3 * sign(v[0]) : 0), of_motor};
    }));
    const FrictionTorques target{r.filtered_tau};
    const std::vector<Coupling> found = find_couplings(std::span(&r, 1), target);
    ASSERT_TRUE(matters(found[1], found[1].r2));
    EXPECT_EQ(found[1].at_joint_too, own);
    EXPECT_EQ(declaration_of(found[1], 1, robot).empty(), own);
    dynamics::RobotModel declared = robot;
    declared.couplings.push_back({1, 0, -1});
    EXPECT_EQ(declaration_of(found[1], 1, declared), "");
  }
}

// Both motors of a differential turn both joints: two couplings declare that.
TEST(Couplings, ThoseOfADifferentialAreDeclaredByTwo) {
  dynamics::RobotModel robot;
  for (const char* name : {"inner", "outer"}) {
    robot.joints.emplace_back();
    robot.joints.back().name = name;
  }
  const auto apart = [](double t) {  // the outer joint first
    return std::array{0.8 * std::sin(2.1 * t + 1), std::sin(1.3 * t)};
  };
  for (const double factor : {1.0, 0.5}) {
    const signals::Recording r =
        swapped(recording(apart, [&](double, const std::array<double, 2>& v) {
          const double one = 3 * sign(v[0] + factor * v[1]), other = 4 * sign(v[0] - factor * v[1]);
          return std::array{one + other, factor * (one - other)};
        }));
    const FrictionTorques target{r.filtered_tau};
    const std::vector<Coupling> found = find_couplings(std::span(&r, 1), target);
    for (const int j : {0, 1}) {
      ASSERT_TRUE(
          matters(found[static_cast<std::size_t>(j)], found[static_cast<std::size_t>(j)].r2));
      const std::string text = declaration_of(found[static_cast<std::size_t>(j)], j, robot);
      EXPECT_THAT(
          text,
          testing::MatchesRegex(
              R"(\[\[robot.coupling\]\] joint = "outer", motor = "inner", factor = -(1|0\.[45].*) and )"
              R"(\[\[robot.coupling\]\] joint = "inner", motor = "outer", factor = (1|2|2\..*|1\.9.*))"))
          << factor << " " << j;
    }
  }
}

// A motor that turns two joints loads both.
TEST(Couplings, NoneIsClaimedWhereOneJointAloneShowsIt) {
  const auto apart = [](double t) {
    return std::array{std::sin(1.3 * t), 0.8 * std::sin(2.1 * t + 1)};
  };
  const auto torque = [](double, const std::array<double, 2>& v) {
    return std::array{3 * sign(v[0] + v[1]), 2 * sign(v[1])};
  };
  EXPECT_EQ(couplings(apart, torque)[0].with, -1);
}

// As of a real arm whose joints were moved one way and at one speed until one of them stopped, with
// a gravity in error.
TEST(Couplings, NoneIsClaimedOfJointsThatTurnTogether) {
  const auto together = [](double t) {
    const double v = 0.006 * t * t;
    return std::array{t < 13 ? v : 0.02 * std::sin(t), v};
  };
  const auto wrong_gravity = [](double t, const std::array<double, 2>& v) {
    const double tau = 2 + v[0] + 0.5 * std::sin(t) - (t < 13 ? 0 : 4);
    return std::array{tau, tau};
  };
  for (const Coupling& coupling : couplings(together, wrong_gravity))
    EXPECT_FALSE(matters(coupling, coupling.r2)) << coupling.share;
}

// Torque that goes its own way over a log of a few swings, whatever the joints do.
TEST(Couplings, NoneIsClaimedOfWhatOtherStretchesOfTheLogDoNotShow) {
  const auto apart = [](double t) {
    return std::array{std::sin(0.4 * t), 0.9 * std::sin(0.55 * t + 1)};
  };
  for (int trial = 0; trial < 12; ++trial) {
    const auto drift = [&](double t, const std::array<double, 2>& v) {
      const double tau = 6 * std::sin((0.25 + 0.03 * trial) * t + 0.7 * trial);
      return std::array{sign(v[0]) + tau, sign(v[1]) + tau};
    };
    for (const Coupling& coupling : couplings(apart, drift))
      EXPECT_FALSE(matters(coupling, coupling.r2)) << trial << " " << coupling.share;
  }
}

}  // namespace
}  // namespace fricid::estimate
