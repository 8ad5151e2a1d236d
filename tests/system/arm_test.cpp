#include "fricid/system/arm.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <bit>
#include <cmath>

#include "allocation_counter.hpp"
#include "flywheel.hpp"
#include "fricid/base/error.hpp"
#include "fricid/base/rng.hpp"
#include "kr6_truth.hpp"

namespace fricid::test {
namespace {

/// State and inputs of an arm on any scalar.
template <class S>
struct Vectors {
  std::vector<S> q, v, z, tau, temperature, tau_f;
  explicit Vectors(const Arm& arm)
      : q(static_cast<std::size_t>(arm.robot.n()), S(0)),
        v(q),
        z(static_cast<std::size_t>(arm.friction.model.state_size()), S(0)),
        tau(q),
        temperature(q.size(), S(kRoomTemperature)),
        tau_f(q) {}
};

template <class S>
void advance(ArmStepper<S>& stepper, Vectors<S>& x) {
  stepper.step(x.tau, x.temperature, kSamplePeriod, x.q, x.v, x.z);
}

/// A random state in lane k, the same for every scalar type.
template <class S>
void fill_lane(Vectors<S>& x, int k, int state) {
  Rng rng(7, static_cast<std::uint64_t>(state));
  const auto set = [&](std::vector<S>& values, double scale) {
    for (S& value : values) {
      const double number = scale * rng.normal();
      set_lane(value, k, static_cast<decltype(lane(value, k))>(number));
    }
  };
  set(x.q, 1);
  set(x.v, 1);
  set(x.z, 1e-4);
  set(x.tau, 20);
}

class EveryLaw : public ::testing::TestWithParam<const char*> {
 protected:
  Arm arm{hanging_kr6(), kr6_friction(GetParam())};
};
INSTANTIATE_TEST_SUITE_P(Laws, EveryLaw,
                         ::testing::Values("coulomb_viscous", "lugre", "gms", "maxwell_slip"));

TEST_P(EveryLaw, LaneEqualsScalarToTheLastBit) {
  Vectors<PackD> lanes(arm);
  for (int k = 0; k < PackD::kLanes; ++k) fill_lane(lanes, k, k);
  ArmStepper<PackD> pack_stepper(arm, {4, 2});
  for (int i = 0; i < 25; ++i) advance(pack_stepper, lanes);
  pack_stepper.friction_torque(lanes.tau, lanes.temperature, lanes.q, lanes.v, lanes.z,
                               lanes.tau_f);

  for (int k = 0; k < PackD::kLanes; ++k) {
    Vectors<double> one(arm);
    fill_lane(one, 0, k);
    ArmStepper<double> stepper(arm, {4, 2});
    for (int i = 0; i < 25; ++i) advance(stepper, one);
    stepper.friction_torque(one.tau, one.temperature, one.q, one.v, one.z, one.tau_f);
    const auto expect_same = [k](const std::vector<PackD>& packs, const std::vector<double>& x) {
      for (std::size_t i = 0; i < x.size(); ++i) {
        EXPECT_TRUE(std::isfinite(x[i]));
        EXPECT_EQ(std::bit_cast<std::uint64_t>(packs[i][k]), std::bit_cast<std::uint64_t>(x[i]))
            << "lane " << k << ": " << packs[i][k] << " and " << x[i];
      }
    };
    expect_same(lanes.q, one.q);
    expect_same(lanes.v, one.v);
    expect_same(lanes.z, one.z);
    expect_same(lanes.tau_f, one.tau_f);
  }
}

TEST_P(EveryLaw, SinglePrecisionLanesDoNotSeeEachOther) {
  Vectors<PackF> full(arm), alone(arm);
  for (int k = 0; k < PackF::kLanes; ++k) fill_lane(full, k, k);
  fill_lane(alone, 2, 2);
  ArmStepper<PackF> stepper(arm, {3});
  for (int i = 0; i < 25; ++i) {
    advance(stepper, full);
    advance(stepper, alone);
  }
  Vectors<double> exact(arm);
  fill_lane(exact, 0, 2);
  ArmStepper<double> double_stepper(arm, {3});
  for (int i = 0; i < 25; ++i) advance(double_stepper, exact);
  for (std::size_t j = 0; j < full.q.size(); ++j) {
    EXPECT_EQ(full.q[j][2], alone.q[j][2]);
    EXPECT_EQ(full.v[j][2], alone.v[j][2]);
    EXPECT_NEAR(full.q[j][2], exact.q[j], 1e-3);  // 100 single-precision steps of a stiff system
  }
}

TEST_P(EveryLaw, StepDoesNotAllocate) {
  Vectors<PackD> x(arm);
  fill_lane(x, 0, 0);
  ArmStepper<PackD> stepper(arm, {2, 2});
  const long before = allocation_count();
  for (int i = 0; i < 10; ++i) advance(stepper, x);
  stepper.friction_torque(x.tau, x.temperature, x.q, x.v, x.z, x.tau_f);
  EXPECT_EQ(allocation_count(), before);
}

// v_{k+1} = (1 - h Fv/I) v_k + h tau/I,  q_{k+1} = q_k + h v_{k+1}: the sums are geometric.
TEST(ArmStepper, FlywheelFollowsTheClosedFormOfItsRecursion) {
  const double inertia = 0.3, Fv = 0.8, tau = 0.5, v0 = -0.7, q0 = 0.2;
  const int substeps = 5, samples = 400;
  const Arm arm = flywheel(inertia, Fv);
  Vectors<double> x(arm);
  x.q[0] = q0;
  x.v[0] = v0;
  x.tau[0] = tau;
  ArmStepper<double> stepper(arm, {substeps});
  for (int k = 0; k < samples; ++k) advance(stepper, x);

  const double h = kSamplePeriod / substeps, r = 1 - h * Fv / inertia, end = tau / Fv;
  const int N = samples * substeps;
  const double power = std::pow(r, N);
  EXPECT_NEAR(x.v[0], end + power * (v0 - end), 1e-13);
  EXPECT_NEAR(x.q[0], q0 + h * (N * end + (v0 - end) * r * (1 - power) / (1 - r)), 1e-12);
}

// Against v(t) = end + (v0 - end) exp(-Fv t / I): a first-order scheme halves its error with its
// step.
TEST(ArmStepper, ConvergesToTheContinuousSolutionAtFirstOrder) {
  const double inertia = 0.3, Fv = 0.8, tau = 0.5, v0 = -0.7, t = 0.4;
  const Arm arm = flywheel(inertia, Fv);
  const auto error = [&](int substeps) {
    Vectors<double> x(arm);
    x.v[0] = v0;
    x.tau[0] = tau;
    ArmStepper<double> stepper(arm, {substeps});
    for (int k = 0; k < 100; ++k) advance(stepper, x);
    const double end = tau / Fv;
    return std::abs(x.v[0] - (end + (v0 - end) * std::exp(-Fv * t / inertia)));
  };
  EXPECT_NEAR(error(4) / error(8), 2, 0.02);
  EXPECT_NEAR(error(8) / error(16), 2, 0.01);
}

// A falling arm without friction keeps its energy up to a ripple of the order of the step.
TEST(ArmStepper, FallingArmKeepsItsEnergy) {
  Arm arm{hanging_kr6(), {friction::RobotFriction(std::vector<friction::JointSpec>(6)), {}}};
  const auto drift = [&](int substeps) {
    Vectors<double> x(arm);
    x.q = {0.3, -0.9, 0.4, 0.5, 0.8, 0.2};
    ArmStepper<double> stepper(arm, {substeps});
    dynamics::Workspace<double> ws(arm.robot);
    const std::span<const double> pi(arm.robot.pi.data(),
                                     static_cast<std::size_t>(arm.robot.pi.size()));
    const auto energy = [&] {
      return dynamics::kinetic_energy(arm.robot, ws, pi, x.q, x.v) +
             dynamics::potential_energy(arm.robot, ws, pi, x.q);
    };
    const double start = energy();
    double largest = 0, kinetic = 0;
    for (int k = 0; k < 250; ++k) {
      advance(stepper, x);
      largest = std::max(largest, std::abs(energy() - start));
      kinetic = std::max(kinetic, dynamics::kinetic_energy(arm.robot, ws, pi, x.q, x.v));
    }
    return largest / kinetic;
  };
  const double coarse = drift(4), fine = drift(8);
  EXPECT_LT(fine, 0.02);
  EXPECT_NEAR(coarse / fine, 2, 0.2);
}

/// Distance [rad, root of the mean square] of a rollout of 0.1 s from the same in eight Euler steps
/// per sample, which made the torque.
double distance_from_euler(const Arm& arm, const Recording& recording, StepOptions options) {
  const auto row = [](const RowMatrix& matrix, Eigen::Index k) {
    return std::vector<double>(matrix.row(k).begin(), matrix.row(k).end());
  };
  const Eigen::Index start = 120, steps = 25;
  Vectors<double> x(arm);
  x.q = row(recording.q, start);
  x.v = row(recording.v, start);
  x.z = row(recording.z, start);
  ArmStepper<double> stepper(arm, options);
  double sum = 0;
  for (Eigen::Index k = start; k < start + steps; ++k) {
    x.tau = row(recording.tau, k);
    advance(stepper, x);
    for (std::size_t j = 0; j < 6; ++j) {
      const double e = x.q[j] - recording.q(k + 1, static_cast<Eigen::Index>(j));
      sum += e * e;
    }
  }
  return std::sqrt(sum / 6 / static_cast<double>(steps));
}

// A leap over m Euler steps errs at second order: a quarter for half the leap, and far less than
// one Euler step of the same length.
TEST_P(EveryLaw, LeapStandsForItsEulerSteps) {
  const Recording recording = record(arm, HangingMotion(1), 150, {8});
  const auto distance = [&](StepOptions options) {
    return distance_from_euler(arm, recording, options);
  };
  const double two = distance({8, 2}), four = distance({8, 4}), eight = distance({8, 8});
  EXPECT_EQ(distance({8, 1}), 0);
  EXPECT_LT(eight, 0.1 * distance({1, 1}));
  EXPECT_LT(four, 0.45 * eight);
  EXPECT_LT(two, 0.45 * four);
  EXPECT_GT(two, 0);
}

// Constant acceleration: a leap is m Euler steps exactly, q = q0 + N h v0 + N (N + 1) h^2 a / 2.
TEST(ArmStepper, LeapIsExactForConstantTorque) {
  const Arm arm = flywheel(0.3, 0);
  Vectors<double> x(arm);
  x.tau[0] = 0.6;
  x.v[0] = 0.1;
  ArmStepper<double> stepper(arm, {8, 4});
  for (int k = 0; k < 50; ++k) advance(stepper, x);
  const double h = kSamplePeriod / 8, a = 2;
  EXPECT_NEAR(x.v[0], 0.1 + 400 * h * a, 1e-13);
  EXPECT_NEAR(x.q[0], 400 * h * 0.1 + 400 * 401 * h * h * a / 2, 1e-13);
}

TEST(ArmStepper, RefusesWhatDoesNotFit) {
  Arm arm = flywheel(1, 0);
  EXPECT_THROW(ArmStepper<double>(arm, {0}), UserError);
  EXPECT_THROW(ArmStepper<double>(arm, {8, 3}), UserError);
  EXPECT_THROW(ArmStepper<double>(arm, {8, 0}), UserError);
  arm.friction = kr6_friction("lugre");
  try {
    ArmStepper<double> stepper(arm, {1});
    FAIL();
  } catch (const UserError& error) {
    EXPECT_THAT(error.what(), ::testing::HasSubstr("friction has 6 joints, the robot has 1"));
  }
}

}  // namespace
}  // namespace fricid::test
