#include "fricid/sim/plant.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "arms.hpp"
#include "fricid/base/error.hpp"
#include "fricid/dynamics/algorithms.hpp"
#include "fricid/sim/simulate.hpp"
#include "fricid/system/arm.hpp"
#include "fricid/system/transmission.hpp"

namespace fricid::sim::test {
namespace {

constexpr double kDt = 0.004;

std::span<const double> parameters(const dynamics::RobotModel& robot) {
  return {robot.pi.data(), static_cast<std::size_t>(robot.pi.size())};
}

State rest(const Plant& plant, std::vector<double> q) {
  return {std::move(q), std::vector<double>(static_cast<std::size_t>(plant.n()), 0.0),
          std::vector<double>(static_cast<std::size_t>(plant.state_size()), 0.0)};
}

// Torques that swing the arm about where it hangs, below its limits.
RowMatrix swinging_torques(int length, int n) {
  RowMatrix tau(length, n);
  const std::array<double, 6> amplitude{25, 40, 15, 6, 5, 3};
  for (int k = 0; k < length; ++k)
    for (int j = 0; j < n; ++j)
      tau(k, j) = amplitude[static_cast<std::size_t>(j)] * std::sin((1 + 0.3 * j) * k * kDt * 3);
  return tau;
}

const std::vector<double> kHanging{0.2, -1.5, 0.3, 0.1, -0.4, 0.2};

// Reference: the engine's forward dynamics and friction, stepped by the same scheme.
TEST(Plant, AgreesWithTheEngine) {
  const scene::Problem problem = resolve(scene("kr6_full"));
  const dynamics::RobotModel& robot = problem.robot;
  const friction::Friction& friction = *problem.scene.friction;
  const MujocoArm arm = make_arm(problem);
  Plant plant(arm, robot, friction);
  constexpr int kLength = 250;
  const RowMatrix tau = swinging_torques(kLength, robot.n());
  const RowMatrix temperature = RowMatrix::Constant(kLength, robot.n(), 293.15);
  const Trace trace = rollout(plant, rest(plant, kHanging), tau, temperature, kDt);

  dynamics::Workspace<double> ws(robot);
  State state = rest(plant, kHanging);
  const auto n = static_cast<std::size_t>(robot.n());
  std::vector<double> net(n), a(n), tau_f(n);
  std::vector<friction::Input<double>> in(n);
  const double h = problem.scene.plant.step_s;
  for (int k = 0; k < kLength; ++k) {
    for (std::size_t j = 0; j < n; ++j) {
      const auto column = static_cast<Eigen::Index>(j);
      ASSERT_NEAR(trace.q(k, column), state.q[j], 1e-9) << "sample " << k << " joint " << j;
      ASSERT_NEAR(trace.v(k, column), state.v[j], 1e-8) << "sample " << k << " joint " << j;
    }
    for (int s = 0; s < steps_per_sample(kDt, h); ++s) {
      for (std::size_t j = 0; j < n; ++j)
        in[j] = {state.q[j], state.v[j], tau(k, static_cast<Eigen::Index>(j)), 293.15};
      friction.model.torque<double>(friction.theta, in, state.z, tau_f);
      for (std::size_t j = 0; j < n; ++j) net[j] = in[j].load - tau_f[j];
      dynamics::forward_dynamics<double>(robot, ws, parameters(robot), state.q, state.v, net, a);
      for (std::size_t j = 0; j < n; ++j) {
        in[j].v = state.v[j] += h * a[j];
        in[j].q = state.q[j] += h * state.v[j];
      }
      friction.model.step<double>(friction.theta, in, h, state.z);
    }
  }
  EXPECT_GT((trace.q.bottomRows(1) - trace.q.topRows(1)).cwiseAbs().maxCoeff(), 0.1) << "it moved";
}

// Reference: the engine at the motors, stepped by the same scheme.
TEST(Plant, AgreesWithTheEngineWhereMotorsAreCoupled) {
  scene::Scene coupled = scene("kr6_full");
  coupled.robot.couplings = {{.joint = "joint_a6", .motor = "joint_a5", .factor = -1},
                             {.joint = "joint_a3", .motor = "joint_a2", .factor = 0.4}};
  const scene::Problem problem = resolve(std::move(coupled));
  const dynamics::RobotModel& robot = problem.robot;
  const Transmission motors(robot);
  const MujocoArm arm = make_arm(problem);
  Plant plant(arm, robot, *problem.scene.friction);
  constexpr int kLength = 250;
  const RowMatrix tau = swinging_torques(kLength, robot.n());
  const RowMatrix temperature = RowMatrix::Constant(kLength, robot.n(), 293.15);
  const Trace trace = rollout(plant, rest(plant, kHanging), tau, temperature, kDt);

  const Arm engine{robot, *problem.scene.friction};
  ArmStepper<double> stepper(engine, {steps_per_sample(kDt, problem.scene.plant.step_s), 1});
  const State start = rest(plant, kHanging);
  RowMatrix q = motors.to_motors(Eigen::Map<const RowMatrix>(start.q.data(), 1, robot.n()));
  std::vector<double> v = start.v, z = start.z, tau_f(v.size());
  const RowMatrix tau_m = motors.torque_to_motors(tau);
  const auto n = v.size();
  for (int k = 0; k < kLength; ++k) {
    const auto at_joints = [&](const double* x) -> RowMatrix {
      return motors.to_joints(Eigen::Map<const RowMatrix>(x, 1, robot.n()));
    };
    const std::span<const double> held(tau_m.row(k).data(), n), warm(temperature.row(k).data(), n);
    EXPECT_LT((trace.q.row(k) - at_joints(q.data())).cwiseAbs().maxCoeff(), 1e-9) << k;
    EXPECT_LT((trace.v.row(k) - at_joints(v.data())).cwiseAbs().maxCoeff(), 1e-8) << k;
    stepper.friction_torque(held, warm, {q.data(), n}, v, z, tau_f);
    const RowMatrix friction =
        motors.torque_to_joints(Eigen::Map<const RowMatrix>(tau_f.data(), 1, robot.n()));
    ASSERT_LT((trace.tau_f.row(k) - friction).cwiseAbs().maxCoeff(), 1e-6) << k;
    stepper.step(held, warm, kDt, {q.data(), n}, v, z);
  }
  EXPECT_GT((trace.q.bottomRows(1) - trace.q.topRows(1)).cwiseAbs().maxCoeff(), 0.1) << "it moved";
}

// Law: without friction and torque energy is conserved, up to the first order of the integrator.
TEST(Plant, ConservesEnergyWithoutFriction) {
  scene::Problem problem = resolve(scene("kr6_gms"));
  const dynamics::RobotModel& robot = problem.robot;
  dynamics::Workspace<double> ws(robot);
  constexpr int kLength = 500;
  const RowMatrix zero = RowMatrix::Zero(kLength, robot.n());
  const auto drift = [&](double step) {
    const MujocoArm arm = make_arm(problem, step);
    Plant plant(arm, robot, no_friction(robot.n()));
    const Trace trace = rollout(plant, rest(plant, {0, -0.6, 0.5, 0.3, 0.8, 0}), zero, zero, kDt);
    double kinetic = 0, worst = 0, start = 0;
    for (int k = 0; k < kLength; ++k) {
      const State state = trace.state(k);
      const double T = dynamics::kinetic_energy(robot, ws, parameters(robot), state.q, state.v);
      const double E = T + dynamics::potential_energy(robot, ws, parameters(robot), state.q);
      if (k == 0) start = E;
      kinetic = std::max(kinetic, T);
      worst = std::max(worst, std::abs(E - start));
    }
    return worst / kinetic;
  };
  const double coarse = drift(5e-4), fine = drift(2.5e-4);
  EXPECT_LT(coarse, 5e-3);
  EXPECT_NEAR(coarse / fine, 2, 0.2);
}

// Claim: counterbalances act as the engine's inverse dynamics has them.
TEST(Plant, CarriesLinearTorques) {
  scene::Problem problem = resolve(scene("kr6_gms"));
  using Shape = dynamics::LinearTorque::Shape;
  dynamics::add_linear_torque(problem.robot, {"c", 1, Shape::kCos, 2}, 12);
  dynamics::add_linear_torque(problem.robot, {"s", 1, Shape::kSin, 1}, -7);
  dynamics::add_linear_torque(problem.robot, {"o", 4, Shape::kConstant, 1}, 0.8);
  dynamics::add_linear_torque(problem.robot, {"k", 2, Shape::kLinear, 1}, 5);
  const dynamics::RobotModel& robot = problem.robot;
  const MujocoArm arm = make_arm(problem);
  Plant plant(arm, robot, *problem.scene.friction);
  constexpr int kLength = 100;
  const Trace trace = rollout(plant, rest(plant, kHanging), swinging_torques(kLength, robot.n()),
                              RowMatrix::Constant(kLength, robot.n(), 293.15), kDt);
  dynamics::Workspace<double> ws(robot);
  std::vector<double> tau(static_cast<std::size_t>(robot.n()));
  for (int k = 0; k < kLength; ++k) {
    const State state = trace.state(k);
    dynamics::rnea<double>(robot, ws, parameters(robot), state.q, state.v,
                           {trace.a.row(k).data(), tau.size()}, tau);
    for (Eigen::Index j = 0; j < robot.n(); ++j)
      ASSERT_NEAR(tau[static_cast<std::size_t>(j)] + trace.tau_f(k, j), trace.tau(k, j), 1e-9);
  }
}

TEST(Plant, RefusesAStepThatDoesNotDivideTheSample) {
  EXPECT_EQ(steps_per_sample(0.004, 0.0005), 8);
  EXPECT_EQ(steps_per_sample(0.004, 0.004), 1);
  EXPECT_THROW(steps_per_sample(0.004, 0.0007), UserError);
  EXPECT_THROW(steps_per_sample(0.004, 0.005), UserError);
}

}  // namespace
}  // namespace fricid::sim::test
