// Friction that grows with the torque of the motor scales the bodies that a regression without it
// finds; where the data show it, it is found beside them.
#include <algorithm>
#include <array>
#include <iterator>

#include <gmock/gmock.h>

#include "arm_data.hpp"
#include "fricid/dynamics/base_parameters.hpp"
#include "fricid/estimate/fit.hpp"
#include "fricid/estimate/rigid_body/identifiability.hpp"

namespace fricid::estimate {
namespace {

using testing::HasSubstr;
using testing::Not;

constexpr double kGrowth = 0.1;

/// Coulomb friction of 2 N m and a tenth of the torque of the motor, in both directions of power.
Arm loaded_arm() {
  Arm arm{small_arm(), {}};
  arm.friction =
      same_law("load_dependent", {2, kGrowth, kGrowth, 0, 0, 2, 5e-3, 0.1}, arm.robot.n());
  return arm;
}

/// The same with the torque that reaches the link.
Arm arm_loaded_behind_its_gears() {
  Arm arm{small_arm(), {}};
  arm.friction.model = friction::RobotFriction(std::vector(
      static_cast<std::size_t>(arm.robot.n()),
      friction::JointSpec{{{"coulomb_viscous", 0, {{"gear_load", 1}}}, {"viscous", 0, {}}}}));
  for (int j = 0; j < arm.robot.n(); ++j)  // Fc, Fv, v0, mu, c, then Fv
    std::ranges::copy(std::array{2.0, 0.0, 5e-3, kGrowth / 2, 2.0, 2.0},
                      std::back_inserter(arm.friction.theta));
  return arm;
}

std::vector<data::Dataset> logs_of(const Arm& arm) {
  return {make_log(arm, {.seconds = 36, .torque_noise = 0.1, .seed = 7})};
}

Prepared prepared_of(const Arm& arm) { return prepare(arm.robot, {}, logs_of(arm), 1); }

/// Largest distance of base parameters from the truth: of all in standard errors, of those that
/// `with` tells to two per cent in the sizes that matter.
struct Misses {
  double size = 0, errors = 0;
};

Misses worst(const RigidBodyFit& fit, const RigidBodyFit& with, const Eigen::VectorXd& truth) {
  const Eigen::ArrayXd off = (fit.base - truth).array().abs();
  const auto told = with.base_se.array() < 0.02 * with.base_size.array();
  return {told.select(off / with.base_size.array(), 0).maxCoeff(),
          (off / fit.base_se.array()).maxCoeff()};
}

TEST(FrictionUnderLoad, BodiesAreRightBesideIt) {
  const Arm arm = loaded_arm();
  const Prepared prepared = prepared_of(arm);
  ASSERT_TRUE(prepared.under_load);
  Eigen::VectorXd pi = Eigen::VectorXd::Zero(prepared.robot.parameter_count());
  pi.head(arm.robot.parameter_count()) = arm.robot.pi;  // offsets are zero
  const Eigen::VectorXd truth = dynamics::base_parameters(prepared.robot).K * pi;

  const RigidBodyFit& fit = *prepared.under_load;
  for (int j = 1; j < arm.robot.n(); ++j) {
    EXPECT_TRUE(fit.shows_growth(j));
    EXPECT_NEAR(fit.growth[j], kGrowth, 0.01) << j;
  }
  const Misses with = worst(fit, fit, truth), without = worst(prepared.rigid_body, fit, truth);
  EXPECT_LT(with.size, 0.03);
  EXPECT_LT(with.errors, 5);
  EXPECT_GT(without.size, 0.08);  // 1 / (1 - g)
  EXPECT_LT(without.errors, 3);   // which its standard errors contain
  EXPECT_TRUE(prepared.rigid_body.lacks_growth);
  EXPECT_FALSE(fit.lacks_growth);
}

// Growth with the torque of the link is the same up and down, and scales no weight.
TEST(FrictionUnderLoad, IsThatOfTheLinkWhereThisLeavesLess) {
  const Arm arm = arm_loaded_behind_its_gears();
  const Prepared prepared = prepared_of(arm);
  ASSERT_TRUE(prepared.under_load);
  EXPECT_EQ(prepared.under_load->growth_of, GearSide::kLink);
  EXPECT_EQ(prepared_of(loaded_arm()).under_load->growth_of, GearSide::kMotor);
  for (int j = 1; j < arm.robot.n(); ++j)
    EXPECT_NEAR(prepared.under_load->growth[j], kGrowth, 0.01) << j;
  Eigen::VectorXd pi = Eigen::VectorXd::Zero(prepared.robot.parameter_count());
  pi.head(arm.robot.parameter_count()) = arm.robot.pi;
  const Eigen::VectorXd truth = dynamics::base_parameters(prepared.robot).K * pi;
  EXPECT_LT(worst(*prepared.under_load, *prepared.under_load, truth).size, 0.03);
  constexpr int kWeight = 1;  // of the second joint, which gravity loads most
  EXPECT_NEAR(prepared.rigid_body.base[kWeight] / truth[kWeight], 1, kGrowth / 2);
  EXPECT_GT(prepared_of(loaded_arm()).rigid_body.base[kWeight] / truth[kWeight], 1 + kGrowth / 2);
}

TEST(FrictionUnderLoad, IsLookedForInTheLawsThatHaveIt) {
  const Prepared prepared = prepared_of(loaded_arm());
  ModelOptions simple, with;
  simple.name = "simple";
  with.name = "load_dependent";
  const FitReport a = fit_conventional(prepared, simple, 1, 2),
                  b = fit_conventional(prepared, with, 1, 2);
  ASSERT_TRUE(fit_file(a).rigid_body.load_growth && fit_file(b).rigid_body.load_growth);
  EXPECT_FALSE(fit_file(a).rigid_body.load_growth->modelled);
  EXPECT_TRUE(fit_file(b).rigid_body.load_growth->modelled);
  for (int j = 0; j < 3; ++j)
    EXPECT_LT(b.residual_rms[static_cast<std::size_t>(j)],
              0.7 * a.residual_rms[static_cast<std::size_t>(j)]);
}

TEST(FrictionUnderLoad, IsNotSeenWhereThereIsNone) {
  const Arm coulomb = coulomb_arm(5e-3);
  Arm stribeck = coulomb;
  stribeck.friction = same_law("lugre", {3, 4.5, 0.1, 3000, 30, 2}, 3);
  for (const Arm& arm : {coulomb, stribeck}) {
    const Prepared prepared = prepared_of(arm);
    EXPECT_FALSE(prepared.under_load);
    EXPECT_FALSE(prepared.rigid_body.lacks_growth);
  }
}

// A LuGre that grows by half a per cent per N m: half of what the regression leaves of the joint
// that gravity loads most.
TEST(FrictionUnderLoad, IsSeenBesideAStribeckCurveAndPresliding) {
  Arm arm{small_arm(), {}};
  arm.friction.model = friction::RobotFriction(std::vector(
      static_cast<std::size_t>(arm.robot.n()), friction::JointSpec{{{"lugre", 0, {{"load", 1}}}}}));
  for (const double mu : {0.0, 0.005}) {
    arm.friction.theta.clear();
    for (int j = 0; j < arm.robot.n(); ++j)  // Fc, Fs, vs, sigma0, sigma1, sigma2, mu
      std::ranges::copy(std::array{3.0, 3.6, 0.1, 1500.0, 15.0, 2.0, mu},
                        std::back_inserter(arm.friction.theta));
    const data::Dataset log =
        make_log(arm, {.seconds = 48, .torque_noise = 0.1, .seed = 7, .repeats = false});
    const Prepared prepared = prepare(arm.robot, {}, std::vector{log}, 1);
    ASSERT_EQ(prepared.under_load.has_value(), mu > 0);
    if (!prepared.under_load) continue;
    EXPECT_TRUE(prepared.under_load->shows_growth(1));
    EXPECT_GT(prepared.under_load->growth[1], 3 * mu);  // of Coulomb friction; viscous grows too
    EXPECT_LT(prepared.under_load->growth[1], 6 * mu + 0.01);
  }
}

TEST(FrictionUnderLoad, IsSaidByCheck) {
  const auto summary_of = [](const Arm& arm) {
    const std::vector<data::Dataset> logs = logs_of(arm);
    const std::vector<signals::Recording> recordings{signals::make_recording(logs[0], 10)};
    return to_summary(examine_data(arm.robot, recordings, {}), arm.robot);
  };
  EXPECT_THAT(summary_of(loaded_arm()), HasSubstr("it grows with the torque of the motor (0."));
  EXPECT_THAT(summary_of(arm_loaded_behind_its_gears()),
              HasSubstr("it grows with the torque that reaches the link (0."));
  EXPECT_THAT(summary_of(coulomb_arm(5e-3)), Not(HasSubstr("grows")));
}

}  // namespace
}  // namespace fricid::estimate
