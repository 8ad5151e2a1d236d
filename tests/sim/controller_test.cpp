#include "fricid/sim/controller.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>

#include "arms.hpp"
#include "fricid/base/error.hpp"
#include "fricid/sim/simulate.hpp"

namespace fricid::sim::test {
namespace {

constexpr double kDt = 0.004;

// Runs a controller on the frictionless arm along amplitude (1 - cos(t)) about where it hangs; the
// largest tracking error over the last second [rad].
double track(const ControllerOptions& config, double amplitude, double seconds) {
  const scene::Problem problem = resolve(scene("kr6_gms"));
  const MujocoArm arm = make_arm(problem);
  Plant plant(arm, problem.robot, no_friction(6));
  Controller controller(config, problem.robot, kDt);
  State state{{0, -1.2, 0.4, 0.2, 0.5, 0}, std::vector<double>(6, 0.0), {}};
  const Eigen::VectorXd q0 = Eigen::Map<Eigen::VectorXd>(state.q.data(), 6);
  plant.set_state(state);
  double error = 0;
  std::vector<double> tau(6);
  const std::vector<double> temperature(6, 293.15);
  const int samples = static_cast<int>(seconds / kDt);
  for (int k = 0; k < samples; ++k) {
    const double t = k * kDt;
    const Reference reference{q0.array() + amplitude * (1 - std::cos(t)),
                              Eigen::VectorXd::Constant(6, amplitude * std::sin(t)),
                              Eigen::VectorXd::Constant(6, amplitude * std::cos(t))};
    controller.torque(reference, state.q, state.v, tau);
    for (int j = 0; j < 6; ++j) {
      const auto i = static_cast<std::size_t>(j);
      if (t > seconds - 1) error = std::max(error, std::abs(reference.q[j] - state.q[i]));
    }
    plant.hold(tau, temperature, steps_per_sample(kDt, arm.step()));
    state = plant.state();
  }
  return error;
}

TEST(Controller, PdWithGravityHoldsStill) {
  EXPECT_LT(track({.kind = ControlLaw::kPdGravity}, 0, 2), 1e-12);
}

// Closed form: PD lags by D^-1 M a / w^2; the exactly linearised loop only by what the hold costs.
TEST(Controller, ComputedTorqueTracks) {
  const double computed = track({.kind = ControlLaw::kComputedTorque}, 0.3, 3);
  const double pd = track({.kind = ControlLaw::kPdGravity}, 0.3, 3);
  std::printf("computed torque %.1e, pd %.1e rad\n", computed, pd);
  EXPECT_LT(computed, 3e-5);
  EXPECT_GT(pd, 5 * computed);
}

TEST(Controller, CascadesIntegralRemovesItsModelError) {
  ControllerOptions config{.kind = ControlLaw::kCascade, .model_error = 0.2};
  EXPECT_LT(track(config, 0, 8), 1e-6);
  config.integral_s = 1e6;
  EXPECT_GT(track(config, 0, 8), 1e-4) << "without the integral the error stays";
}

TEST(Controller, SaturatesAtTheEffortLimits) {
  const scene::Problem problem = resolve(scene("kr6_gms"));
  for (const ControlLaw kind :
       {ControlLaw::kPdGravity, ControlLaw::kComputedTorque, ControlLaw::kCascade}) {
    Controller controller({.kind = kind, .bandwidth_hz = 20}, problem.robot, kDt);
    const std::vector<double> q(6, 0.1), v(6, 0.0);
    std::vector<double> tau(6);
    const Eigen::VectorXd far = Eigen::VectorXd::Constant(6, 9.0), rest = Eigen::VectorXd::Zero(6);
    controller.torque({far, rest, rest}, q, v, tau);
    for (std::size_t j = 0; j < 6; ++j)
      EXPECT_EQ(std::abs(tau[j]), problem.robot.joints[j].effort)
          << name_of(kind) << " joint " << j;
  }
}

}  // namespace
}  // namespace fricid::sim::test
