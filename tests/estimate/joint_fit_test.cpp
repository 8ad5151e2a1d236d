// Friction and rigid body fitted together, the parts of the sum of laws and what held-out data
// choose, on logs of a small arm.
#include "fricid/estimate/torque/joint_fit.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "arm_data.hpp"
#include "fricid/base/error.hpp"
#include "fricid/data/model_file.hpp"
#include "fricid/estimate/fit.hpp"
#include "fricid/estimate/torque/sum_fit.hpp"
#include "fricid/estimate/torque/sum_start.hpp"

namespace fricid::estimate {
namespace {

/// What two logs of an arm say before a fit.
Prepared prepared_of(const Arm& truth, const RigidBodyOptions& options, LogOptions of_log = {}) {
  std::vector<data::Dataset> logs;
  for (const std::uint64_t seed : {1, 2}) {
    of_log.seed = seed;
    logs.push_back(make_log(truth, of_log));
  }
  return prepare(truth.robot, options, logs, 2);
}

/// A small arm whose friction grows with load and ripples, and what is known before a fit.
struct Logs {
  Arm truth;
  Prepared prepared;
  MultiStepOptions windows;

  Logs() {
    truth.robot = small_arm();
    const friction::JointSpec joint{{{"dahl", 0, {{"load", 1}, {"ripple", 1}}}}};
    truth.friction.model = friction::RobotFriction({joint, joint, joint});
    // Fc, sigma0, Fv, mu, n, A, phi
    for (const double size : {1.0, 0.8, 0.5})
      for (const double value : {6 * size, 3000 * size, 2 * size, 0.02, 100.0, 0.04, 0.7})
        truth.friction.theta.push_back(value);
    RigidBodyOptions options;
    options.min_speed_rad_s = 0.1;
    prepared = prepared_of(truth, options);
    windows.iterations = 20;
  }
};

const Logs& logs() {
  static const Logs made;
  return made;
}

double parameter(const Arm& arm, int joint, std::string_view owner, std::string_view symbol) {
  const int at = friction::find_parameter(arm.friction.model, joint, owner, symbol);
  return arm.friction.theta.at(static_cast<std::size_t>(at));
}

// Load and gravity look alike: alternating fits leave mu at a fraction of its value.
TEST(ArmTorqueFit, FindsLoadRippleAndGravityTogether) {
  JointFits fits(logs().prepared, logs().windows, 2);
  const Arm start = fits.start(logs().truth.friction.model.joints()[0]);
  fits.take_load_of(fits.on_torque(start, JointFits::Rows::kAll).arm);
  const ArmTorqueFit fit = fits.on_torque(start, JointFits::Rows::kAll);
  ASSERT_NE(fit.outcome, Outcome::kFailed) << fit.message;
  for (int j = 0; j < 3; ++j) {
    const double size = j == 0 ? 1 : j == 1 ? 0.8 : 0.5;
    EXPECT_NEAR(parameter(fit.arm, j, "dahl", "Fc"), 6 * size, 0.05 * size) << j;
    EXPECT_NEAR(parameter(fit.arm, j, "load", "mu"), 0.02, 2e-3) << j;
    EXPECT_NEAR(parameter(fit.arm, j, "ripple", "n1"), 100, 0.5) << j;
    EXPECT_NEAR(parameter(fit.arm, j, "ripple", "A1"), 0.04, 4e-3) << j;
    EXPECT_LT(fit.sigma[j], 0.02 * size) << j;
  }
}

TEST(ArmTorqueFit, DoesNotDependOnTheNumberOfThreads) {
  const Arm start =
      JointFits(logs().prepared, logs().windows, 1).start(friction::JointSpec{{{"dahl", 0, {}}}});
  const ArmTorqueFit one =
      JointFits(logs().prepared, logs().windows, 1).on_torque(start, JointFits::Rows::kTraining);
  const ArmTorqueFit three =
      JointFits(logs().prepared, logs().windows, 3).on_torque(start, JointFits::Rows::kTraining);
  EXPECT_EQ(one.arm.friction.theta, three.arm.friction.theta);
  EXPECT_EQ(one.arm.robot.pi, three.arm.robot.pi);
}

// What a fit holds stays, what it may move ends inside its bounds.
TEST(ArmTorqueFit, KeepsToItsLimits) {
  const JointFits fits(logs().prepared, logs().windows, 2);
  const Arm start = fits.start(std::vector<friction::LvmParts>(3, {.elements = 3, .ripples = 0}));
  const ArmTorqueFit fit = fits.on_torque(start, JointFits::Rows::kAll);
  for (const Limit& limit : sum_limits(start)) {
    EXPECT_GE(fit.arm.friction.theta[limit.parameter], limit.lower * (1 - 1e-12));
    EXPECT_LE(fit.arm.friction.theta[limit.parameter], limit.upper * (1 + 1e-12));
  }
}

// What grows with the load has no Coulomb friction of its own.
TEST(SumStart, LawsBeginWithEqualSharesOfCoulombFriction) {
  const SumStart known{.joints = std::vector<friction::FrictionGuess>(3, {.Fc = 6, .Fv = 1}),
                       .load = {1, 1, 1},
                       .temperature = 293};
  const friction::JointSpec joint{
      {{"maxwell_slip", 2, {{"load", 1}}}, {"stribeck", 0, {}}, {"load_dependent", 0, {}}}};
  const Arm start = start_sum(logs().truth, std::vector<friction::JointSpec>(3, joint), known);
  EXPECT_NEAR(parameter(start, 0, "maxwell_slip", "W1"), 1.5, 1e-12);
  EXPECT_NEAR(parameter(start, 0, "stribeck", "Fc"), 3, 1e-12);
  EXPECT_LT(parameter(start, 0, "load_dependent", "Fc"), 1e-3);
  for (const Limit& limit : sum_limits(start)) {
    const friction::ParameterRef& p = start.friction.model.parameters()[limit.parameter];
    EXPECT_TRUE(p.info.role != friction::Role::kCoulomb || p.owner == "load_dependent");
    if (p.owner == "load") {
      EXPECT_NEAR(limit.upper, 0.3 / 3, 1e-12);
    }
  }
}

TEST(SumStart, SlidingJointsHaveATenthOfTheSpeedsAndLengths) {
  Arm arm = logs().truth;
  arm.robot.joints[1].type = dynamics::JointType::kPrismatic;
  SumStart known{.joints = std::vector<friction::FrictionGuess>(3, {.Fc = 5, .Fv = 1}),
                 .load = {1, 1, 1},
                 .temperature = 293};
  const Arm start =
      start_sum(arm, std::vector<friction::JointSpec>(3, friction::lvm_sum({})), known);
  const auto at = [&](int joint, std::string_view symbol) {
    return parameter(start, joint, "gms", symbol);
  };
  EXPECT_NEAR(at(1, "vs"), 0.1 * at(0, "vs"), 1e-12);
  EXPECT_NEAR(at(1, "k1"), 10 * at(0, "k1"), 1e-6 * at(0, "k1"));
  EXPECT_EQ(at(2, "vs"), at(0, "vs"));
  for (const Limit& limit : sum_limits(start)) {
    const friction::ParameterRef& p = start.friction.model.parameters()[limit.parameter];
    if (p.symbol != "vs") continue;
    EXPECT_NEAR(limit.lower, p.joint == 1 ? 0.002 : 0.02, 1e-12);
  }
}

// Friction that grows with a load that contains it would explain itself.
TEST(ArmTorqueFit, TakesNoMoreThanAShareOfTheLoadForFriction) {
  const JointFits fits(logs().prepared, logs().windows, 2);
  const Arm start = fits.start(std::vector<friction::LvmParts>(3, {.elements = 3, .ripples = 0}));
  int growths = 0;
  for (const Limit& limit : sum_limits(start)) {
    const auto& p = start.friction.model.parameters()[limit.parameter];
    if (p.owner != "load") continue;
    EXPECT_LE(limit.upper * parameter(start, p.joint, "gms", "Fc"), 0.3 * (1 + 1e-12));
    ++growths;
  }
  EXPECT_EQ(growths, 3);
}

// A torque that no part describes: with the measured torque as load, friction that grows with it
// describes it all the same.
TEST(JointFits, TheLoadOfFrictionDoesNotContainWhatItHasToExplain) {
  Prepared disturbed = logs().prepared;
  for (signals::Recording& r : disturbed.recordings)
    for (Eigen::Index k = 0; k < r.filtered_tau.rows(); ++k)
      r.filtered_tau(k, 0) += 2 * std::sin(9 * static_cast<double>(k) * r.dt);
  for (signals::Recording& r : disturbed.recordings) r.load = r.filtered_tau;
  const JointFits fits(disturbed, logs().windows, 2);
  const Arm start = fits.start(friction::JointSpec{{{"dahl", 0, {{"load", 1}}}}});
  const ArmTorqueData measured(disturbed.robot, disturbed.recordings, disturbed.options.cutoff_hz);
  ArmTorqueOptions options;
  options.nominal = disturbed.robot.pi;
  options.rigid_body = disturbed.options;
  options.coordinates.torque_scale = torque_rms(disturbed.recordings);
  options.coordinates.limits = sum_limits(start);
  const auto growth = [&](const ArmTorqueFit& fit) {
    return parameter(fit.arm, 0, "load", "mu");  // 0.02 in truth
  };
  EXPECT_LT(growth(fits.on_torque(start, JointFits::Rows::kAll)), 0.02);
  EXPECT_GT(growth(fit_arm_torque(measured, start, options, 2)), 0.04);
}

// Friction that grows with its own load by more than the load has no value.
TEST(JointFits, FrictionHasAValueUnderItsOwnLoad) {
  Prepared steep = logs().prepared;
  for (signals::Recording& r : steep.recordings)
    for (Eigen::Index k = 0; k < r.filtered_tau.rows(); ++k) {
      const double load = r.load(k, 1);
      r.filtered_tau(k, 1) += 1.5 * load * load / r.load.col(1).cwiseAbs().maxCoeff() *
                              std::tanh(r.wide.v(k, 1) / 0.03);
    }
  const JointFits fits(steep, logs().windows, 2);
  Arm start = fits.start(friction::JointSpec{{{"dahl", 0, {}}, {"load_dependent", 0, {}}}});
  for (const char* nu : {"nu_m", "nu_b"})
    start.friction.theta[static_cast<std::size_t>(
        friction::find_parameter(start.friction.model, 1, "load_dependent", nu))] = 0.05;
  const Arm fitted = fits.on_torque(start, JointFits::Rows::kAll).arm;
  const ArmTorqueData data(steep.robot, steep.recordings, steep.options.cutoff_hz);
  EXPECT_LT(data.load_gain(fitted, 1), 0.7);
  for (const signals::Recording& r : steep.recordings)
    EXPECT_LT(predict_torque(fitted, r, steep.options.cutoff_hz).cwiseAbs().maxCoeff(),
              3 * r.filtered_tau.cwiseAbs().maxCoeff());
}

/// The truth with other friction, as an arm of the same type has it.
Arm sibling(double factor) {
  Arm arm = logs().truth;
  arm.robot = logs().prepared.robot;
  for (int j = 0; j < 3; ++j) {
    const auto at = [&](std::string_view owner, std::string_view symbol) -> double& {
      const int p = friction::find_parameter(arm.friction.model, j, owner, symbol);
      return arm.friction.theta[static_cast<std::size_t>(p)];
    };
    at("dahl", "Fc") *= factor;
    at("dahl", "Fv") /= factor;
    at("ripple", "A1") = 0;
  }
  return arm;
}

// A narrow prior keeps friction where it is, a wide one leaves it to the data; waves are never in
// it.
TEST(JointFits, ArePulledToAPrior) {
  const Arm prior = sibling(1.3);
  for (const double sd : {1e-4, 10.0}) {
    JointFits fits(logs().prepared, logs().windows, 2);
    fits.take_prior(prior, sd);
    const Arm fitted = fits.on_torque(prior, JointFits::Rows::kAll).arm;
    for (int j = 0; j < 3; ++j) {
      const double known = parameter(prior, j, "dahl", "Fc"),
                   truth = parameter(logs().truth, j, "dahl", "Fc");
      EXPECT_NEAR(parameter(fitted, j, "dahl", "Fc"), sd < 1 ? known : truth, 0.1 * truth);
      if (sd > 1)
        EXPECT_NEAR(parameter(fitted, j, "ripple", "A1"), 0.04, 0.01);
      else
        EXPECT_NE(parameter(fitted, j, "ripple", "A1"), 0);
    }
  }
}

// On a few seconds the laws of an arm of the same type are worth more than what the data choose.
TEST(SumFit, TakesTheLawsOfAPriorOnAShortLog) {
  JointFits fits(logs().prepared, logs().windows, 2);
  ASSERT_TRUE(fits.is_short());
  std::vector<friction::LvmParts> parts;
  std::vector<PartEvidence> evidence;
  const Arm prior = sibling(1.1);
  fits.take_prior(prior, 0.2);
  fits.take_load_of(fits.on_torque(prior, JointFits::Rows::kTraining).arm);
  const Candidate found = fit_sum(fits, parts, evidence);
  EXPECT_EQ(found.name, "like the prior");
  EXPECT_NEAR(parameter(found.arm, 0, "load", "mu"), 0.02, 5e-3);
  EXPECT_TRUE(parts.empty());
}

TEST(FitModel, RefusesAPriorOfAnotherArmOrLaw) {
  const std::string file = testing::TempDir() + "fricid_prior.json";
  ModelOptions config;
  config.name = "mine";
  config.method = Method::kJoint;
  config.laws = {{.law = "dahl", .elements = 4, .modifiers = {"load", "ripple"}}};
  config.prior = file;
  const auto error = [&](const Arm& prior) -> std::string {
    data::save_model({.name = "other", .label = "other", .arm = prior}, file);
    try {
      fit_model(logs().prepared, config, 1, 2);
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

// Fits to the training rows do not know the torque that judges them.
TEST(JointFits, TrainingRowsAreNotTheHeldOutOnes) {
  Prepared other = logs().prepared;
  const Split split = split_recordings(other.recordings, logs().windows.hold_out);
  for (std::size_t s = 0; s < other.recordings.size(); ++s) {
    auto& tau = other.recordings[s].filtered_tau;
    tau.bottomRows(tau.rows() - split.test_begin[s]) *= 2;
  }
  const JointFits seen(logs().prepared, logs().windows, 2), unseen(other, logs().windows, 2);
  const Arm start = seen.start(friction::JointSpec{{{"dahl", 0, {}}}});
  const auto fit = [&](const JointFits& fits, JointFits::Rows rows) {
    return fits.on_torque(start, rows).arm.friction.theta;
  };
  EXPECT_EQ(fit(seen, JointFits::Rows::kTraining), fit(unseen, JointFits::Rows::kTraining));
  EXPECT_NE(fit(seen, JointFits::Rows::kAll), fit(unseen, JointFits::Rows::kAll));
}

// Starts from rest are rare, and a model that fails in them alone is still wrong.
TEST(JointFits, StartsOfLongLogsAreJudged) {
  for (const bool is_long : {false, true}) {
    LogOptions of_log;
    if (is_long) of_log.seconds = 36;
    const Prepared right = prepared_of(logs().truth, logs().prepared.options, of_log);
    Prepared wrong = right;
    for (signals::Recording& r : wrong.recordings) r.held_tau.row(1).array() += 50;
    const auto judged = [&](const Prepared& prepared) {
      const Arm truth{prepared.robot, logs().truth.friction};
      return JointFits(prepared, logs().windows, 2).judged("truth", truth, 0).rollouts;
    };
    const RolloutErrors a = judged(right), b = judged(wrong);
    const auto unlike = [](const std::vector<double>& x, const std::vector<double>& y) {
      std::ptrdiff_t count = 0;
      for (std::size_t i = 0; i < x.size(); ++i) count += std::abs(x[i] - y[i]) > 0.1;
      return count;
    };
    EXPECT_EQ(unlike(a.seconds, b.seconds), is_long ? 2 : 0);
    EXPECT_EQ(unlike(a.whole, b.whole), is_long ? 2 : 0);
  }
}

/// The small arm with friction of one form. @param theta  of each joint
Arm arm_with(const friction::JointSpec& joint, const std::vector<std::vector<double>>& theta) {
  Arm arm = logs().truth;
  arm.friction.model = friction::RobotFriction({joint, joint, joint});
  arm.friction.theta.clear();
  for (const std::vector<double>& of_joint : theta)
    arm.friction.theta.insert(arm.friction.theta.end(), of_joint.begin(), of_joint.end());
  return arm;
}

/// What its logs with noise say: without, fits that stop early have gains that no data could show.
Prepared noisy_logs(const Arm& truth, double seconds) {
  return prepared_of(truth, logs().prepared.options,
                     {.seconds = seconds, .torque_noise = 0.05, .encoder_noise = 4e-6});
}

/// What the sum of a truth of three joints has.
std::vector<friction::LvmParts> parts_found(const friction::JointSpec& joint,
                                            const std::vector<std::vector<double>>& theta) {
  const Prepared prepared = noisy_logs(arm_with(joint, theta), 36);
  JointFits fits(prepared, logs().windows, 2);
  const Arm start = fits.start(fits.all_parts());
  fits.take_load_of(fits.on_torque(start, JointFits::Rows::kTraining).arm);
  std::vector<friction::LvmParts> parts;
  std::vector<PartEvidence> evidence;
  fit_sum(fits, parts, evidence);
  return parts;
}

// Load and power flow stand for each other: one goes, not both.
TEST(SumFit, HasThePartsOfTheTruth) {
  int load = 0, ripple = 0, inner_viscous = 0;
  std::vector<std::vector<double>> theta;
  for (const double size : {1.0, 0.8, 0.5})  // Fc, sigma0, Fv, mu, n, A, phi
    theta.push_back({6 * size, 3000 * size, 2 * size, 0.02, 100, 0.04, 0.7});
  for (const friction::LvmParts& part :
       parts_found({{{"dahl", 0, {{"load", 1}, {"ripple", 1}}}}}, theta)) {
    load += part.load;
    ripple += part.ripples > 0;
    inner_viscous += part.inner_viscous;
  }
  EXPECT_EQ(load, 3);
  EXPECT_EQ(ripple, 3);
  EXPECT_EQ(inner_viscous, 3);
}

TEST(SumFit, ViscousFrictionThatLoadDoesNotScaleStaysOutOfTheMemory) {
  std::vector<std::vector<double>> theta;
  for (const double size : {1.0, 0.8, 0.5})  // Fc, sigma0, Fv, mu, then Fv beside
    theta.push_back({6 * size, 3000 * size, 0, 0.02, 2 * size});
  for (const friction::LvmParts& part :
       parts_found({{{"dahl", 0, {{"load", 1}}}, {"viscous", 0, {}}}}, theta)) {
    EXPECT_TRUE(part.load);
    EXPECT_FALSE(part.inner_viscous);
  }
}

// No sum is exact here, so that every parameter makes up for something; and a part that says
// nothing gains more than its standard error in one case of six.
TEST(SumFit, LacksThePartsThatTheTruthLacks) {
  int parts = 0;
  for (const double stiffness : {0.6, 1.0, 1.7}) {
    std::vector<std::vector<double>> theta;
    for (const double size : {1.0, 0.8, 0.5}) {  // Fc, Fv, then k, alpha of each spring
      const double k = stiffness * size;
      theta.push_back({6 * size, 3 * size, 6000 * k, 0.4, 2000 * k, 0.3, 500 * k, 0.3});
    }
    for (const friction::LvmParts& part : parts_found({{{"prandtl_ishlinskii", 3, {}}}}, theta))
      parts += part.load + part.power_flow + part.asymmetry;
  }
  EXPECT_LE(parts, 13);  // of 27
}

// A gap and a second wave: in the joint that has them, of the size that they have.
TEST(SumFit, FindsGapsAndFurtherRipples) {
  Arm truth = logs().truth;
  truth.friction.model = friction::RobotFriction(
      {{{{"dahl", 0, {{"backlash", 1}}}}}, {{{"dahl", 0, {{"ripple", 2}}}}}, {{{"dahl", 0, {}}}}});
  truth.friction.theta = {6, 3000, 2,   3e-4,                              // b
                          5, 2400, 1.6, 100,  0.04, 0.7, 262, 0.03, -1.2,  // n, A, phi twice
                          3, 1500, 1};
  const Prepared prepared = prepared_of(truth, logs().prepared.options);
  const JointFits fits(prepared, logs().windows, 2);
  std::vector<friction::LvmParts> parts;
  std::vector<PartEvidence> evidence;
  const Candidate sum = fit_sum(fits, parts, evidence);
  EXPECT_TRUE(parts[0].backlash);
  EXPECT_NEAR(parameter(sum.arm, 0, "backlash", "b"), 3e-4, 3e-5);
  EXPECT_FALSE(parts[1].backlash);
  EXPECT_FALSE(parts[2].backlash);
  EXPECT_EQ(parts[1].ripples, 2);
  EXPECT_NEAR(parameter(sum.arm, 1, "ripple", "n1"), 100, 0.5);
  EXPECT_NEAR(parameter(sum.arm, 1, "ripple", "n2"), 262, 0.5);
  EXPECT_NEAR(parameter(sum.arm, 1, "ripple", "A2"), 0.03, 4e-3);
  for (const auto& p : sum.arm.friction.model.parameters()) {
    if (p.joint != 2 || p.info.role != friction::Role::kAmplitude) continue;
    EXPECT_LT(parameter(sum.arm, 2, "ripple", p.symbol), 3e-3);  // logs without noise show all
  }
}

// A bank stands for a bristle behind a gap: neither a bristle nor a gap alone betters it.
TEST(SumFit, FindsBristlesBehindGaps) {
  std::vector<std::vector<double>> theta;
  for (const double Fc : {6.0, 5.0, 3.0})  // Fc, sigma0, Fv, mu, b
    theta.push_back({Fc, 2000 * Fc, Fc / 3, 0.01, 2e-4});
  const Prepared prepared = prepared_of(
      arm_with({{{"dahl", 0, {{"load", 1}, {"backlash", 1}}}}}, theta), logs().prepared.options);
  const JointFits fits(prepared, logs().windows, 2);
  std::vector<friction::LvmParts> parts;
  std::vector<PartEvidence> evidence;
  const Candidate sum = fit_sum(fits, parts, evidence);
  for (int j = 0; j < 3; ++j) {
    const friction::LvmParts& of_joint = parts[static_cast<std::size_t>(j)];
    EXPECT_EQ(of_joint.memory, friction::Memory::kBristle) << j;
    ASSERT_TRUE(of_joint.backlash) << j;
    EXPECT_NEAR(parameter(sum.arm, j, "backlash", "b"), 2e-4, 2e-5) << j;
  }
}

// Friction that lags is in no law of the sum.
TEST(JointFits, NetworksLearnWhatNoLawDescribes) {
  std::vector<std::vector<double>> theta;
  for (const double size : {1.0, 0.8, 0.5})  // Fc, Fs, vs, Fv, v0, T
    theta.push_back({6 * size, 6.5 * size, 0.06, 2 * size, 0.01, 0.02});
  const Prepared prepared =
      prepared_of(arm_with({{{"lagged_stribeck", 0, {}}}}, theta), logs().prepared.options);
  const JointFits fits(prepared, logs().windows, 2);
  friction::LvmParts plain{.memory = friction::Memory::kNone,
                           .load = false,
                           .power_flow = false,
                           .asymmetry = false,
                           .ripples = 0};
  const auto fitted = [&](const friction::LvmParts& parts) {
    Arm arm = fits.start(std::vector<friction::LvmParts>(3, parts));
    for (int pass = 0; pass < 3; ++pass)  // each weighs the joints by what the last one left
      arm = fits.on_torque(arm, JointFits::Rows::kTraining, false).arm;
    return arm;
  };
  const Arm without = fitted(plain);
  set(plain, friction::SumPart::kNetwork, true);
  const Arm with = fitted(plain);
  EXPECT_LT(fits.held_out_torque(with), 0.2 * fits.held_out_torque(without));
  for (int j = 0; j < 3; ++j)
    EXPECT_TRUE(fits.compare(with, without, j, friction::SumPart::kNetwork).on) << j;
}

// Levels that grow with speed and unload with the springs, under a ripple: the sum has the ripple,
// the network the levels, which does not see the joint angle. Neither is enough.
TEST(JointFits, NetworksLearnWhatTheSumLeaves) {
  std::vector<std::vector<double>> theta;
  for (const double size : {1.0, 0.8, 0.5})  // Fc, Fv, k and alpha of each spring, n, A, phi
    theta.push_back(
        {6 * size, 5 * size, 3000 * size, 0.4, 800 * size, 0.3, 200 * size, 0.3, 100, 0.04, 0.7});
  const Prepared prepared =
      noisy_logs(arm_with({{{"prandtl_ishlinskii", 3, {{"ripple", 1}}}}}, theta), 26);
  const JointFits fits(prepared, logs().windows, 2);
  const auto fitted = [&](int ripples, int units, const Arm* from) {
    const friction::LvmParts parts{.load = false,
                                   .power_flow = false,
                                   .asymmetry = false,
                                   .ripples = ripples,
                                   .network = units};
    const Arm start = fits.start(std::vector<friction::LvmParts>(3, parts));
    return fits
        .on_torque(from ? carried_over(*from, start) : start, JointFits::Rows::kTraining, !from)
        .arm;
  };
  const Arm sum = fitted(1, 0, nullptr);
  const double both = fits.held_out_torque(fitted(1, friction::kNetworkUnits, &sum));
  EXPECT_LT(both, 0.6 * fits.held_out_torque(sum));
  EXPECT_LT(both, 0.3 * fits.held_out_torque(fitted(0, friction::kNetworkUnits, &sum)));
}

// From an arm whose friction is off, windows and torque together find back.
TEST(JointFits, WindowsBetterAnArmThatIsOff) {
  const JointFits fits(logs().prepared, logs().windows, 2);
  const Arm start = fits.start(logs().truth.friction.model.joints()[0]);
  Arm off = fits.on_torque(start, JointFits::Rows::kTraining).arm;
  for (const int j : {0, 2})
    off.friction.theta[static_cast<std::size_t>(
        friction::find_parameter(off.friction.model, j, "dahl", "Fc"))] *= 1.03;
  const Candidate before = fits.judged("off", off, 0), after = fits.on_windows(before, "test");
  EXPECT_LT(after.held_out, 0.1 * before.held_out);
  EXPECT_LT(after.torque, before.torque);

  const JointFits one(logs().prepared, logs().windows, 1);
  const Candidate again = one.on_windows(before, "test");
  EXPECT_EQ(again.arm.friction.theta, after.arm.friction.theta);
  EXPECT_EQ(again.arm.robot.pi, after.arm.robot.pi);
}

// Held-out rollouts and torque choose one of all, which the fits to folds start from.
TEST(FitModel, LvmTakesTheCandidateThatHeldOutDataChoose) {
  ModelOptions config;
  config.name = config.law = "lvm";
  config.method = Method::kJoint;
  config.train = logs().windows;
  const FitReport report = fit_model(logs().prepared, config, 1, 2);
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
}

// Friction that lags behind the speed by a time is in no law of the sum.
TEST(FitModel, LvmTakesNetworksWhereNoLawDescribesTheFriction) {
  std::vector<std::vector<double>> theta;
  for (const double size : {1.0, 0.8, 0.5})  // Fc, Fs, vs, Fv, v0, T
    theta.push_back({6 * size, 6.5 * size, 0.06, 2 * size, 0.01, 0.02});
  const Prepared prepared = noisy_logs(arm_with({{{"lagged_stribeck", 0, {}}}}, theta), 26);
  ModelOptions config;
  config.name = config.law = "lvm";
  config.method = Method::kJoint;
  config.train = logs().windows;
  const FitReport report = fit_model(prepared, config, 1, 2);
  const Candidate& taken = *std::ranges::find(report.candidates, true, &Candidate::taken);
  EXPECT_TRUE(has_networks(taken.arm)) << taken.name;
  for (const Candidate& other : report.candidates)
    if (!has_networks(other.arm)) {
      EXPECT_LT(taken.torque, 0.1 * other.torque) << other.name;
    }
  EXPECT_LT(taken.held_out, 0.1 * report.candidates[0].held_out);  // the sum without networks
}

}  // namespace
}  // namespace fricid::estimate
