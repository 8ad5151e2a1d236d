// Identification of what the simulator made: the one place where both meet.
#include <gmock/gmock.h>

#include "arms.hpp"
#include "fricid/estimate/fit.hpp"
#include "fricid/sim/simulate.hpp"
#include "kr6_truth.hpp"
#include "recovery.hpp"

namespace fricid::sim::test {
namespace {

// kr6_gms with Coulomb and viscous friction of a KR 6 in its place.
scene::Scene coulomb_viscous_scene() {
  scene::Scene result = scene("kr6_gms");
  const friction::JointSpec spec{{{"coulomb_viscous", 0, {}}}};
  result.friction = fricid::test::make_friction(
      6, spec, [](int joint, std::string_view, std::string_view symbol) {
        const auto& scale = fricid::test::kJointScales[static_cast<std::size_t>(joint)];
        return symbol == "Fc" ? scale.Fc : symbol == "Fv" ? scale.Fv : 1e-3;
      });
  result.excitation.repeats = 1;
  result.excitation.restarts = 2;
  result.excitation.validation = 0;
  return result;
}

estimate::ModelOptions simple() {
  estimate::ModelOptions config;
  config.name = "simple";
  return config;
}

// Reference: the injected truth. The Plant's semi-implicit Euler step h shows in the data like an
// armature of Fv h, 0.05 % of that of the wrist at 20 us, so the truth is made at that step.
TEST(Identification, FindsTheTruthOfTheSimulatorWithoutNoise) {
  scene::Scene exact = coulomb_viscous_scene();
  exact.plant.step_s = 2e-5;
  exact.sensors.encoder_noise_rad.clear();
  exact.sensors.encoder_step_rad.clear();
  exact.sensors.torque_noise = exact.sensors.torque_step = 0;
  const scene::Problem problem = resolve(std::move(exact));
  const Simulation simulation = simulate(problem, 2);
  std::vector<signals::Recording> sequences;
  for (const data::Dataset& log : simulation.train)
    sequences.push_back(signals::make_recording(log, problem.scene.identify.cutoff_hz));
  const estimate::RigidBodyFit fit =
      estimate::rigid_body_least_squares(problem.robot, sequences, {});
  ASSERT_EQ(fit.outcome, estimate::Outcome::kConverged) << fit.message;
  estimate::expect_base_parameters(problem.robot, fit.base, sequences, 1e-3);
  for (int j = 0; j < 6; ++j) {
    const auto& scale = fricid::test::kJointScales[static_cast<std::size_t>(j)];
    EXPECT_NEAR(fit.Fc[j], scale.Fc, 1e-3 * scale.Fc) << "joint " << j;
    EXPECT_NEAR(fit.Fv[j], scale.Fv, 1e-3 * scale.Fv) << "joint " << j;
  }
}

// Reference: the injected truth; noise as in the scenes of a KR 6: torque 0.5 % of the effort
// limit, encoder one count. Of 300 estimates a normal distribution puts 0.8 beyond 3 standard
// errors.
TEST(Identification, IsWithinThreeStandardErrorsUnderNoise) {
  scene::Scene noisy = coulomb_viscous_scene();
  noisy.plant.step_s = 1e-4;
  noisy.sensors.torque_noise = 0.005;
  const scene::Problem problem = resolve(std::move(noisy));
  const Simulation simulation = simulate(problem, 2);
  const estimate::Prepared prepared =
      estimate::prepare(problem.robot, problem.scene.identify, simulation.train, 2);
  const estimate::RigidBodyFit& fit = prepared.rigid_body;
  ASSERT_EQ(fit.outcome, estimate::Outcome::kConverged) << fit.message;
  const auto base = dynamics::base_parameters(prepared.robot);
  const Eigen::VectorXd truth = base.K * prepared.robot.pi;
  for (Eigen::Index i = 0; i < truth.size(); ++i)
    EXPECT_NEAR(fit.base[i], truth[i], 3 * fit.base_se[i])
        << fit.base_names[static_cast<std::size_t>(i)];
  for (int j = 0; j < 6; ++j) {
    const auto& scale = fricid::test::kJointScales[static_cast<std::size_t>(j)];
    EXPECT_NEAR(fit.Fc[j], scale.Fc, 3 * fit.Fc_se[j]) << "joint " << j;
    EXPECT_NEAR(fit.Fv[j], scale.Fv, 3 * fit.Fv_se[j]) << "joint " << j;
  }
}

// With the sensors of the scenes the linear law of the table comes out, too.
TEST(Identification, SimpleModelHoldsTheTrueFriction) {
  const scene::Problem problem = resolve(coulomb_viscous_scene());
  const Simulation simulation = simulate(problem, 2);
  const estimate::Prepared prepared =
      estimate::prepare(problem.robot, problem.scene.identify, simulation.train, 2);
  const estimate::FitReport report = estimate::fit_conventional(prepared, simple(), 1, 2);
  ASSERT_TRUE(report.usable()) << report.message;
  for (int j = 0; j < 6; ++j) {
    const auto& scale = fricid::test::kJointScales[static_cast<std::size_t>(j)];
    const auto& theta = report.joints[static_cast<std::size_t>(j)].theta;
    EXPECT_NEAR(theta[0], scale.Fc, 5e-3 * scale.Fc) << "joint " << j;
    EXPECT_NEAR(theta[1], scale.Fv, 1e-2 * scale.Fv) << "joint " << j;
  }
}

}  // namespace
}  // namespace fricid::sim::test
