// Fits of method joint: laws of one's own, priors, and which candidate the lvm takes.
#include "fricid/estimate/fit.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <iterator>
#include <numbers>
#include <optional>

#include "fricid/base/error.hpp"
#include "fricid/data/fit_file.hpp"
#include "fricid/data/log_part.hpp"
#include "fricid/data/model_file.hpp"
#include "fricid/estimate/torque/carry_over.hpp"
#include "fricid/estimate/torque/networks.hpp"
#include "joint_logs.hpp"

namespace fricid::estimate {
namespace {

ModelOptions the_lvm() {
  ModelOptions config;
  config.name = config.law = "lvm";
  config.method = Method::kJoint;
  config.train = logs().windows;
  return config;
}

ModelOptions laws_of_ones_own(std::vector<LawOptions> laws) {
  ModelOptions config;
  config.name = "mine";
  config.laws = std::move(laws);
  config.method = Method::kJoint;
  config.train = logs().windows;
  return config;
}

Arm fitted_arm(const Prepared& prepared, const ModelOptions& config) {
  ConventionalFits conventional(prepared);
  return fit_model(conventional, config, 1, 2).model.arm;
}

TEST(FitModel, RefusesAPriorOfAnotherArmOrLaw) {
  const std::string file = testing::TempDir() + "fricid_prior.json";
  ModelOptions config =
      laws_of_ones_own({{.law = "dahl", .elements = 4, .modifiers = {"load", "ripple"}}});
  config.prior = file;
  const auto error = [&](const Arm& prior) -> std::string {
    data::save_model({.name = "other", .label = "other", .arm = prior}, file);
    try {
      ConventionalFits conventional(logs().prepared);
      fit_model(conventional, config, 1, 2);
    } catch (const UserError& e) {
      return e.what();
    }
    return "";
  };
  EXPECT_EQ(error(sibling(1.1)), "");
  Arm renamed = sibling(1.1);
  renamed.robot.joints[1].name = "elbow";
  EXPECT_NE(error(renamed).find("elbow"), std::string::npos) << error(renamed);
  Arm lacking = sibling(1.1);
  lacking.robot = logs().truth.robot;
  EXPECT_NE(error(lacking).find("a rigid body of"), std::string::npos) << error(lacking);
  config.laws[0].modifiers = {"load"};
  EXPECT_NE(error(sibling(1.1)).find("other laws"), std::string::npos);
  std::filesystem::remove(file);
}

// A few seconds of a torque that no law explains: a flexible law and all inertias fit it together.
TEST(FitModel, APoorSumOnAShortLogHasOneNearTheRegressionBesideIt) {
  const ModelOptions config = the_lvm();
  const auto candidates = [&](const Prepared& prepared) {
    ConventionalFits conventional(prepared);
    return fit_model(conventional, config, 1, 2).candidates;
  };
  const auto near = [](const std::vector<Candidate>& of) {
    return std::ranges::find(of, "sum near the regression", &Candidate::name);
  };
  const Prepared noisy = prepared_of(logs().truth, logs().prepared.options, {.torque_noise = 2});
  const std::vector<Candidate> found = candidates(noisy), exact = candidates(logs().prepared);
  ASSERT_NE(near(found), found.end());
  const auto distance = [&](const Candidate& of) {
    const RigidBodyFit& fit = noisy.rigid_body;
    return ((fit.base_of_pi * (of.arm.robot.pi - fit.pi)).array() / fit.base_se.array())
        .matrix()
        .norm();
  };
  EXPECT_LT(distance(*near(found)), 0.85 * distance(found.front()));
  EXPECT_EQ(near(exact), exact.end());
}

// A wave of an eccentric gear is slower than what a gear's teeth make, for which the first fit
// looks.
TEST(FitModel, LawsOfOnesOwnFindSlowWaves) {
  std::vector<std::vector<double>> theta;
  for (const double size : {1.0, 0.8, 0.5})  // Fc, sigma0, Fv, n, A, phi, then c, p, v0
    theta.push_back({6 * size, 3000 * size, 0, 2, 0.1, 0.5, 3 * size, 0.6, 0.01});
  const Prepared prepared =
      noisy_logs(arm_with({{{"dahl", 0, {{"ripple", 1}}}, {"viscous_power", 0, {}}}}, theta), 36);
  const Arm arm = fitted_arm(
      prepared, laws_of_ones_own({{.law = "dahl", .elements = 4, .modifiers = {"ripple"}},
                                  {.law = "viscous_power", .elements = 4, .modifiers = {}}}));
  for (int j = 0; j < 3; ++j) {
    EXPECT_NEAR(parameter(arm, j, "ripple", "n1"), 2, 0.1) << j;
    EXPECT_NEAR(parameter(arm, j, "ripple", "A1"), 0.1, 0.02) << j;
    EXPECT_NEAR(parameter(arm, j, "viscous_power", "p"), 0.6, 0.1) << j;
  }
}

// A first fit gives all of it to the linear viscous friction of the Dahl law, which leaves p
// without a gradient.
TEST(FitModel, LawsOfOnesOwnFindAConvexPowerLaw) {
  std::vector<std::vector<double>> theta;
  for (const double size : {1.0, 0.8, 0.5})  // Fc, sigma0, Fv, then c, p, v0
    theta.push_back({6 * size, 3000 * size, 0, 3 * size, 1.4, 0.01});
  const Prepared prepared =
      noisy_logs(arm_with({{{"dahl", 0, {}}, {"viscous_power", 0, {}}}}, theta), 36);
  const Arm arm = fitted_arm(
      prepared, laws_of_ones_own({{.law = "dahl", .elements = 4, .modifiers = {}},
                                  {.law = "viscous_power", .elements = 4, .modifiers = {}}}));
  for (int j = 0; j < 3; ++j) EXPECT_NEAR(parameter(arm, j, "viscous_power", "p"), 1.4, 0.15) << j;
}

// The lvm bounds the Stribeck velocity of its memory by .5 rad/s; a law that is asked for is not.
TEST(FitModel, LawsOfOnesOwnMayHaveAWideStribeckCurve) {
  std::vector<std::vector<double>> theta;
  for (const double size : {1.0, 0.8, 0.5})  // Fc, Fs, vs, sigma0, sigma1, sigma2
    theta.push_back({6 * size, 9 * size, 0.9, 8000 * size, 10 * size, 2 * size});
  const Prepared prepared =
      prepared_of(arm_with({{{"lugre", 0, {}}}}, theta), logs().prepared.options,
                  {.seconds = 50,
                   .peak_speed = 3,
                   .torque_noise = 0.05,
                   .encoder_noise = 4e-6,
                   .repeats = false});
  const Arm arm =
      fitted_arm(prepared, laws_of_ones_own({{.law = "lugre", .elements = 4, .modifiers = {}}}));
  for (int j = 0; j < 3; ++j) EXPECT_NEAR(parameter(arm, j, "lugre", "vs"), 0.9, 0.2) << j;
}

// A bristle of 20 mrad is still bending while the speed passes the Stribeck curve.
TEST(FitModel, LawsOfOnesOwnFindAStribeckCurveBehindASoftBristle) {
  std::vector<std::vector<double>> theta;
  for (const double size : {1.0, 0.8, 0.5})  // Fc, Fs, vs, sigma0, sigma1, sigma2
    theta.push_back({7 * size, 8.4 * size, 0.05, 350 * size, 2 * size, 2.8 * size});
  const Prepared prepared = noisy_logs(arm_with({{{"lugre", 0, {}}}}, theta), 60);
  const Arm arm =
      fitted_arm(prepared, laws_of_ones_own({{.law = "lugre", .elements = 4, .modifiers = {}}}));
  for (int j = 0; j < 3; ++j) {
    EXPECT_NEAR(parameter(arm, j, "lugre", "vs"), 0.05, 0.02) << j;
    EXPECT_NEAR(parameter(arm, j, "lugre", "Fs") / parameter(arm, j, "lugre", "Fc"), 1.2, 0.1) << j;
  }
}

// A curve of .02 rad/s that falls towards rest stands for a smoothing speed of .05 at first.
TEST(FitModel, LawsOfOnesOwnFindASmoothWideStribeckCurve) {
  std::vector<std::vector<double>> theta;
  for (const double size : {1.0, 0.8, 0.5})  // Fc, Fs, vs, Fv, v0
    theta.push_back({7 * size, 10.5 * size, 0.4, 2 * size, 0.05});
  const Prepared prepared = noisy_logs(arm_with({{{"stribeck", 0, {}}}}, theta), 60);
  const Arm arm =
      fitted_arm(prepared, laws_of_ones_own({{.law = "stribeck", .elements = 4, .modifiers = {}}}));
  for (int j = 0; j < 3; ++j) {
    EXPECT_NEAR(parameter(arm, j, "stribeck", "vs"), 0.4, 0.02) << j;
    EXPECT_NEAR(parameter(arm, j, "stribeck", "v0"), 0.05, 0.005) << j;
  }
}

// The spring of a cable that begins as stiff as a bristle may take its place, and the bristle that
// of the cable.
TEST(FitModel, LawsOfOnesOwnTellACableFromABristle) {
  std::vector<std::vector<double>> theta;
  for (const double size : {1.0, 0.8, 0.5})  // Fc, Fs, vs, sigma0, sigma1, sigma2, then K, W
    theta.push_back(
        {7 * size, 9.1 * size, 0.05, 7000 * size, 14 * size, 2.8 * size, 21 * size, 4.2 * size});
  const Prepared prepared =
      noisy_logs(arm_with({{{"lugre", 0, {}}, {"maxwell_slip", 1, {}}}}, theta), 60);
  const Arm arm = fitted_arm(
      prepared, laws_of_ones_own({{.law = "lugre", .elements = 4, .modifiers = {}},
                                  {.law = "maxwell_slip", .elements = 1, .modifiers = {}}}));
  for (int j = 0; j < 3; ++j) {
    const double size = theta[static_cast<std::size_t>(j)][0] / 7;
    EXPECT_NEAR(parameter(arm, j, "lugre", "sigma0"), 7000 * size, 700 * size) << j;
    EXPECT_NEAR(parameter(arm, j, "maxwell_slip", "K1"), 21 * size, 2 * size) << j;
  }
}

TEST(CarryOver, PutsASpringThatTookTheBristlesPlaceBack) {
  const friction::JointSpec joint{{{"lugre", 0, {}}, {"maxwell_slip", 1, {}}}};
  const std::vector<double> right{7, 9.1, 0.05, 7000, 14, 2.8, 21, 4.2},
      swapped{4.2, 5, 0.4, 21, 4, 2.8, 7000, 7};
  EXPECT_FALSE(with_springs_in_place(arm_with(joint, {right, right, right})));
  const std::optional<Arm> mended = with_springs_in_place(arm_with(joint, {right, swapped, right}));
  ASSERT_TRUE(mended);
  for (int j = 0; j < 3; ++j) {
    EXPECT_EQ(parameter(*mended, j, "lugre", "sigma0"), 7000) << j;
    EXPECT_EQ(parameter(*mended, j, "lugre", "Fc"), 7) << j;
    EXPECT_EQ(parameter(*mended, j, "maxwell_slip", "K1"), 21) << j;
    EXPECT_EQ(parameter(*mended, j, "maxwell_slip", "W1"), 4.2) << j;
  }
  EXPECT_NEAR(parameter(*mended, 1, "lugre", "Fs"), 8.4, 1e-12);
}

TEST(CarryOver, OrdersWavesByAmplitude) {
  const friction::JointSpec joint{{{"dahl", 0, {{"ripple", 2}}}}};
  const std::vector<double> theta{6, 3000, 2, 100, 0.001, 0.7, 3, 0.1, -1.2};
  const Arm ordered = with_strongest_waves_first(arm_with(joint, {theta, theta, theta}));
  for (int j = 0; j < 3; ++j) {
    EXPECT_EQ(parameter(ordered, j, "ripple", "n1"), 3) << j;
    EXPECT_EQ(parameter(ordered, j, "ripple", "phi1"), -1.2) << j;
    EXPECT_EQ(parameter(ordered, j, "ripple", "A2"), 0.001) << j;
  }
}

// Two stiff springs and two soft ones are two.
TEST(CarryOver, JoinsSpringsOfAboutTheSameTravel) {
  const auto arm = [](int springs, const std::vector<double>& k_alpha) {
    std::vector<double> theta{6, 7, 0.05, 100, 2};  // Fc, Fs, vs, C, Fv
    theta.insert(theta.end(), k_alpha.begin(), k_alpha.end());
    return arm_with({{{"gms", springs, {}}}}, {theta, theta, theta});
  };
  const Arm two =
      with_springs_joined(arm(4, {60, 0.05, 3000, 0.05, 300, 0.25, 0.65 * 6000 / 0.66, 0.65 / 6}),
                          arm(2, {1, 1, 1, 1}));
  EXPECT_NEAR(parameter(two, 0, "gms", "alpha1") + parameter(two, 0, "gms", "alpha2"),
              0.35 + 0.65 / 6, 1e-12);
  EXPECT_NEAR(parameter(two, 0, "gms", "k1"), 3000 + 0.65 * 6000 / 0.66, 1e-9);
  EXPECT_NEAR(parameter(two, 0, "gms", "k2"), 360, 1e-9);
}

// A phase begins anew at pi, and the exponent of a torque that is absent says nothing.
TEST(FitModel, PhasesAndIdleExponentsAreOnNoBound) {
  const ModelOptions config =
      laws_of_ones_own({{.law = "dahl", .elements = 4, .modifiers = {"ripple"}},
                        {.law = "viscous_power", .elements = 4, .modifiers = {}}});
  ConventionalFits conventional(logs().prepared);
  FitReport report = fit_model(conventional, config, 1, 2);
  friction::Friction& friction = report.model.arm.friction;
  const auto value = [&](std::string_view owner, std::string_view symbol) -> double& {
    return friction.theta[static_cast<std::size_t>(
        friction::find_parameter(friction.model, 0, owner, symbol))];
  };
  const auto at_bound = [&] { return fit_file(report).joints[0].at_bound; };
  report.errors.root.setOnes();
  value("ripple", "phi1") = std::numbers::pi;
  value("viscous_power", "p") = 2;
  value("viscous_power", "c") = 1e-3;
  EXPECT_EQ(at_bound(), std::vector<std::string>());
  value("viscous_power", "c") = 1;
  EXPECT_EQ(at_bound(), std::vector<std::string>{"p"});
}

// A prior of another arm of the same joints, laws and friction five times as high, moves nothing.
TEST(FitModel, LeavesOutAPriorThatTheTorqueContradicts) {
  const std::string file = testing::TempDir() + "fricid_wrong_prior.json";
  ModelOptions config =
      laws_of_ones_own({{.law = "dahl", .elements = 4, .modifiers = {"load", "ripple"}}});
  const auto fitted = [&](const Arm* prior) {
    config.prior = prior ? file : "";
    if (prior) data::save_model({.name = "other", .label = "other", .arm = *prior}, file);
    ConventionalFits conventional(logs().prepared);
    return fit_model(conventional, config, 1, 2);
  };
  const Arm right = sibling(1.1), wrong = sibling(5);
  const FitReport without = fitted(nullptr), with_wrong = fitted(&wrong),
                  with_right = fitted(&right);
  for (std::size_t i = 0; i < without.model.arm.friction.theta.size(); ++i)
    EXPECT_NEAR(with_wrong.model.arm.friction.theta[i] / without.model.arm.friction.theta[i], 1,
                0.01);
  EXPECT_NE(with_wrong.prior_left_out.value_or("").find("the prior is left out"),
            std::string::npos);
  EXPECT_NE(with_right.model.arm.friction.theta, without.model.arm.friction.theta);
  EXPECT_FALSE(with_right.prior_left_out);
  EXPECT_EQ(fit_file(with_wrong).prior_left_out, with_wrong.prior_left_out);
  std::filesystem::remove(file);
}

// What a prior that stays has is no choice of parts: there is none to put networks beside.
TEST(Networks, AreNotLookedForBesideTheLawsOfAPrior) {
  const JointFits fits(logs().prepared, logs().windows, 2);
  std::vector<PartEvidence> evidence;
  const Arm prior = sibling(1);
  EXPECT_FALSE(fit_networks(fits, prior, prior, {}, evidence));
  EXPECT_TRUE(evidence.empty());
}

// Held-out rollouts and torque choose one of all, which the fits to folds start from.
TEST(FitModel, LvmTakesTheCandidateThatHeldOutDataChoose) {
  const ModelOptions config = the_lvm();
  ConventionalFits conventional(logs().prepared);
  const FitReport report = fit_model(conventional, config, 1, 2);
  ASSERT_TRUE(report.has_result()) << report.message;
  ASSERT_GE(report.candidates.size(), 7u);
  const Candidate& taken = report.candidates[choose(report.candidates)];
  EXPECT_TRUE(taken.taken);
  EXPECT_EQ(std::ranges::count(report.candidates, true, &Candidate::taken), 1);
  EXPECT_EQ(report.model.arm.friction.theta, taken.arm.friction.theta);
  const Split split = split_recordings(logs().prepared.recordings, config.train.hold_out);
  EXPECT_EQ(taken.held_out,
            held_out_error(taken.arm, logs().prepared.recordings, split, config.train.judge, 2));
  ASSERT_EQ(report.without.size(), 2u);
  EXPECT_NE(report.without[0].arm.friction.theta, report.without[1].arm.friction.theta);

  // its base parameters are those of its bodies, not of the regression before it
  ASSERT_EQ(report.errors.draws.size(), 39u);
  const data::FitFile file = fit_file(report);
  const Eigen::VectorXd base = report.rigid_body.base_of_pi * report.model.arm.robot.pi;
  for (Eigen::Index i = 0; i < base.size(); ++i) {
    const data::FittedBaseParameter& of_file = file.rigid_body.base[static_cast<std::size_t>(i)];
    EXPECT_EQ(of_file.physical, base[i]);
    EXPECT_EQ(of_file.value, base[i]);
    EXPECT_GT(report.rigid_body.base_se[i], 0);
  }
  // and its friction has errors
  ASSERT_EQ(file.joints.size(), 3u);
  const friction::Friction& friction = report.model.arm.friction;
  int stated = 0;
  for (int i = 0; i < friction.model.parameter_count(); ++i) {
    const auto p = static_cast<std::size_t>(i);
    const data::FittedParameter* found = data::fitted_parameter(file, friction.model, i);
    ASSERT_NE(found, nullptr);
    EXPECT_EQ(found->value, friction.theta[p]);
    const double square =
        report.errors.root.row(report.model.arm.robot.pi.size() + i).squaredNorm();
    if (square == 0)  // held
      EXPECT_TRUE(std::isnan(found->standard_error));
    else
      EXPECT_NEAR(found->standard_error, std::sqrt(square), 1e-9 * std::sqrt(square));
    stated += square > 0;
  }
  EXPECT_GE(stated, 9);
}

// As of a wrist whose coupling nobody declared: a model of any law is then of the wrong joints.
TEST(FitModel, JointFitsNameCoupledFriction) {
  const Arm arm = coulomb_arm(5e-3);
  std::vector<data::Dataset> coupled;
  for (const std::uint64_t seed : {1, 2}) {
    LogOptions options{.seconds = 24, .torque_noise = 0.05, .repeats = false};
    options.seed = seed;
    data::Dataset& log = coupled.emplace_back(make_log(arm, options));
    const signals::Recording motion = signals::make_recording(log, 10);
    for (Eigen::Index k = 0; k < log.tau.rows(); ++k) {
      const double motor = 6 * std::tanh((motion.wide.v(k, 1) + motion.wide.v(k, 2)) / 0.02);
      log.tau(k, 1) += motor;
      log.tau(k, 2) += motor;
    }
  }
  const Prepared prepared = prepare(arm.robot, {}, coupled, 2);
  ConventionalFits conventional(prepared);
  const ModelOptions config = laws_of_ones_own({{.law = "dahl", .elements = 4, .modifiers = {}}});
  const FitReport report = fit_model(conventional, config, 1, 2);
  EXPECT_TRUE(std::ranges::any_of(report.faults, [](const Fault& fault) {
    return fault.found.find("depends on the speed of") != std::string::npos;
  }));
}

// Power flow stands for gear load: what knows neither is nearer.
TEST(FitModel, LvmFindsASmoothWideStribeckCurveUnderGearLoad) {
  std::vector<std::vector<double>> theta;
  const double mu[] = {0.012, 0.015, 0.03};
  for (std::size_t j = 0; j < 3; ++j) {
    const double size = 1 - 0.25 * static_cast<double>(j);  // Fc, Fs, vs, Fv, v0, mu, c
    theta.push_back({7 * size, 10.5 * size, 0.4, 2.1 * size, 0.05, mu[j], 0});
  }
  const Prepared prepared =
      noisy_logs(arm_with({{{"stribeck", 0, {{"gear_load", 1}}}}}, theta), 40);
  const Arm arm = fitted_arm(prepared, the_lvm());
  for (int j = 0; j < 3; ++j) {
    const friction::LvmParts parts = friction::parts_of(arm.friction, j);
    ASSERT_TRUE(parts.memory == friction::Memory::kNone && parts.gear_load) << j;
    EXPECT_NEAR(parameter(arm, j, "gear_load", "mu"), mu[j], 0.1 * mu[j]) << j;
    EXPECT_NEAR(parameter(arm, j, "stribeck", "vs"), 0.4, 0.04) << j;
  }
}

// Friction that lags behind the speed by a time is in no law of the sum. Beside a bank of springs,
// which stands for much of it, the first rough steps of networks gain little.
TEST(FitModel, LvmTakesNetworksWhereNoLawDescribesTheFriction) {
  const friction::JointSpec joint{{{"gms", 3, {}}, {"lagged_stribeck", 0, {}}}};
  std::vector<std::vector<double>> theta;
  for (const double size : {1.0, 0.8, 0.5})
    theta.push_back({3 * size, 3.6 * size, 0.05, 90 * size, size,           // Fc Fs vs C Fv
                     1800 * size, 0.4, 600 * size, 0.35, 150 * size, 0.25,  // k, alpha
                     3 * size, 3.25 * size, 0.1, 2 * size, 0.01, 0.008});   // Fc Fs vs Fv v0 T
  const Prepared prepared = noisy_logs(arm_with(joint, theta), 50);
  const ModelOptions config = the_lvm();
  ConventionalFits conventional(prepared);
  const FitReport report = fit_model(conventional, config, 1, 2);
  const Candidate& taken = *std::ranges::find(report.candidates, true, &Candidate::taken);
  EXPECT_TRUE(has_networks(taken.arm)) << taken.name;
  for (const Candidate& other : report.candidates)
    if (!has_networks(other.arm)) {
      EXPECT_LT(taken.torque, 0.1 * other.torque) << other.name;
    }
  EXPECT_LT(taken.held_out, 0.1 * report.candidates[0].held_out);  // the sum without networks
  int off = 0;  // of what the sum without networks has
  for (const PartEvidence& part : report.parts) {
    EXPECT_EQ(part.on,
              friction::has(friction::parts_of(taken.arm.friction, part.joint), part.part));
    off += !part.on;
  }
  EXPECT_GT(off, 0);
  const auto remarks = fit_file(report).remarks;
  EXPECT_TRUE(remarks && std::ranges::any_of(*remarks, [](const data::FittedRemark& remark) {
                return remark.found.starts_with("networks hold a part of the friction of ");
              }));
}

}  // namespace
}  // namespace fricid::estimate
