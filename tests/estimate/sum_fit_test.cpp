// The sum of laws: how it starts, which parts of it the data choose, and which candidate the lvm
// takes, on logs of a small arm.
#include "fricid/estimate/torque/sum_fit.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <iterator>

#include "fricid/base/error.hpp"
#include "fricid/data/fit_file.hpp"
#include "fricid/data/log_part.hpp"
#include "fricid/data/model_file.hpp"
#include "fricid/estimate/fit.hpp"
#include "fricid/estimate/torque/networks.hpp"
#include "fricid/estimate/torque/sum_start.hpp"
#include "joint_logs.hpp"

namespace fricid::estimate {
namespace {

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
    EXPECT_NEAR(limit.lower, p.joint == 1 ? 5e-4 : 5e-3, 1e-12);
  }
}

// On a few seconds the laws of an arm of the same type are worth more than what the data choose.
TEST(SumFit, TakesTheLawsOfAPriorOnAShortLog) {
  JointFits fits(logs().prepared, logs().windows, 2);
  ASSERT_TRUE(fits.is_short());
  std::vector<friction::LvmParts> parts;
  std::vector<PartEvidence> evidence;
  const Arm prior = sibling(1.1);
  fits.take_prior(ArmPrior{prior, 0.2});
  fits.take_load_of(fits.on_torque(prior, JointFits::Rows::kTraining).arm);
  const Candidate found = fit_sum(fits, fits.start(fits.all_parts()), parts, evidence);
  EXPECT_EQ(found.name, "like the prior");
  EXPECT_NEAR(parameter(found.arm, 0, "load", "mu"), 0.02, 5e-3);
  EXPECT_TRUE(parts.empty());
}

/// The sum fitted to logs, and its parts.
struct FittedSum {
  Arm arm;
  std::vector<friction::LvmParts> parts;
};
FittedSum sum_of(const Prepared& prepared) {
  JointFits fits(prepared, logs().windows, 2);
  FittedSum sum;
  std::vector<PartEvidence> evidence;
  sum.arm = fit_sum(fits, fits.start(fits.all_parts()), sum.parts, evidence).arm;
  return sum;
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
  fit_sum(fits, fits.start(fits.all_parts()), parts, evidence);
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
  EXPECT_GE(inner_viscous, 2);  // joint 0 shows it by 1.2 standard errors
}

// Growth with what reaches the link: 2 of 6 N m of friction differ from that with the motor's.
TEST(SumFit, TellsTheLoadOfTheLinkFromThatOfTheMotor) {
  const auto gears_of = [](const char* modifier, std::vector<double> growth) {
    std::vector<std::vector<double>> theta;
    for (const double size : {1.0, 0.8, 0.5}) {  // Fc, sigma0, Fv, mu (and c), then Fv beside
      theta.push_back({6 * size, 3000 * size, 0});
      std::ranges::copy(growth, std::back_inserter(theta.back()));
      theta.back().push_back(2 * size);
    }
    int gears = 0;
    for (const friction::LvmParts& part :
         parts_found({{{"dahl", 0, {{modifier, 1}}}, {"viscous", 0, {}}}}, theta))
      gears += part.gear_load;
    return gears;
  };
  EXPECT_EQ(gears_of("gear_load", {0.03, 2}), 3);
  EXPECT_EQ(gears_of("load", {0.03}), 0);
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

// Friction of the speed that grows with the load, beside a memory that does not.
TEST(SumFit, PutsLoadOnViscousFrictionAndOnAStribeckTorque) {
  std::vector<std::vector<double>> theta;
  for (const double size : {1.0, 0.8, 0.5})  // Fc, sigma0, Fv, then Fv and mu
    theta.push_back({6 * size, 3000 * size, 0, 2 * size, 0.03});
  for (const friction::LvmParts& part :
       parts_found({{{"dahl", 0, {}}, {"viscous", 0, {{"load", 1}}}}}, theta)) {
    EXPECT_TRUE(part.loaded_viscous);
    EXPECT_FALSE(part.loaded_stribeck);
  }

  theta.clear();
  for (const double size : {1.0, 0.8, 0.5})  // Fc, sigma0, Fv, then Ts, vs, v0 and mu
    theta.push_back({6 * size, 3000 * size, 2 * size, 3 * size, 0.1, 0.01, 0.03});
  int loaded = 0;
  for (const friction::LvmParts& part :
       parts_found({{{"dahl", 0, {}}, {"stribeck_peak", 0, {{"load", 1}}}}}, theta)) {
    loaded += part.loaded_stribeck;
    EXPECT_FALSE(part.loaded_viscous);
  }
  EXPECT_GE(loaded, 2);
}

// Power flow that is larger in one direction, beside a memory that is not. The same of both is
// none of it.
TEST(SumFit, PutsTheDirectionOnPowerFlow) {
  const auto modified = [](const friction::LawSpec& flow) {
    std::vector<std::vector<double>> theta;
    for (const double size : {1.0, 0.8, 0.5}) {  // Fc, sigma0, Fv, then those of the flow, and a
      theta.push_back({6 * size, 3000 * size, 2 * size, 1e-6, 0.15, 0.1, 0, 0, 0, 0.03, 0.3});
      if (!flow.modifiers.empty()) theta.back().push_back(0.4);
    }
    int count = 0;
    for (const friction::LvmParts& part : parts_found({{{"dahl", 0, {}}, flow}}, theta))
      count += part.further_modifiers;
    return count;
  };
  EXPECT_GE(modified({"load_dependent", 0, {{"asymmetry", 1}}}), 2);
  EXPECT_EQ(modified({"load_dependent", 0, {}}), 0);
}

// A bristle with a Stribeck torque that does not wait for it: the memory's own would.
TEST(SumFit, HasAStribeckTorqueBesideTheMemory) {
  std::vector<std::vector<double>> theta;
  for (const double size : {1.0, 0.8, 0.5})  // Fc, sigma0, Fv, then Ts, vs, v0
    theta.push_back({6 * size, 1500 * size, 2 * size, 3 * size, 0.1, 0.01});
  int beside = 0;
  for (const friction::LvmParts& part :
       parts_found({{{"dahl", 0, {}}, {"stribeck_peak", 0, {}}}}, theta))
    beside += part.stribeck;
  EXPECT_EQ(beside, 3);

  for (std::vector<double>& of_joint : theta) of_joint.resize(3);
  for (const friction::LvmParts& part : parts_found({{{"dahl", 0, {}}}}, theta))
    EXPECT_FALSE(part.stribeck);
}

// A bank or a stiff bristle, with a Stribeck torque beside it, stands for friction without memory.
TEST(SumFit, HasNoMemoryWhereTheTruthHasNone) {
  std::vector<std::vector<double>> theta;
  for (const double size : {1.0, 0.8, 0.5})  // Fc, Fs, vs, Fv, v0, mu
    theta.push_back({6 * size, 7 * size, 0.1, 2 * size, 0.03, 0.02});
  const Prepared prepared = noisy_logs(arm_with({{{"stribeck", 0, {{"load", 1}}}}}, theta), 36);
  const auto [sum, parts] = sum_of(prepared);
  for (int j = 0; j < 3; ++j) {
    const friction::LvmParts& of_joint = parts[static_cast<std::size_t>(j)];
    ASSERT_TRUE(of_joint.memory == friction::Memory::kNone && !of_joint.stribeck) << j;
    EXPECT_TRUE(of_joint.inner_viscous) << j;
    EXPECT_NEAR(parameter(sum, j, "stribeck", "v0"), 0.03, 0.006) << j;
    EXPECT_NEAR(parameter(sum, j, "load", "mu"), 0.02, 0.004) << j;
  }
}

// Eight seconds held out are no proof in one joint; all three say the same.
TEST(SumFit, HasAStribeckTorqueOnAShortLogByAllJointsTogether) {
  std::vector<std::vector<double>> theta;
  for (const double size : {1.0, 0.8, 0.5})  // Fc, sigma0, Fv, then Ts, vs, v0
    theta.push_back({6 * size, 3000 * size, 2 * size, 2 * size, 0.15, 0.01});
  const Prepared prepared =
      noisy_logs(arm_with({{{"dahl", 0, {}}, {"stribeck_peak", 0, {}}}}, theta), 20);
  JointFits fits(prepared, logs().windows, 2);
  ASSERT_TRUE(fits.is_short());
  std::vector<friction::LvmParts> parts;
  std::vector<PartEvidence> evidence;
  fit_sum(fits, fits.start(fits.all_parts()), parts, evidence);
  EXPECT_GE(std::ranges::count(parts, true, &friction::LvmParts::stribeck), 2);
}

// Until a slow wave is found nothing shows that viscous friction is under it too.
TEST(SumFit, PutsViscousFrictionUnderASlowWave) {
  std::vector<std::vector<double>> theta;
  for (const double size : {1.0, 0.8, 0.5})  // Fc, Fv, v0, n, A, phi, a
    theta.push_back({6 * size, 3 * size, 0.01, 3, 0.1, 0.3, 0.15});
  const Prepared prepared = noisy_logs(
      arm_with({{{"coulomb_viscous", 0, {{"ripple", 1}, {"asymmetry", 1}}}}}, theta), 50);
  const auto [sum, parts] = sum_of(prepared);
  for (int j = 0; j < 3; ++j) {
    EXPECT_TRUE(parts[static_cast<std::size_t>(j)].inner_viscous) << j;
    EXPECT_EQ(parts[static_cast<std::size_t>(j)].ripples, 1) << j;  // none of a gear's teeth
    EXPECT_NEAR(parameter(sum, j, "ripple", "n1"), 3, 0.1) << j;
    EXPECT_NEAR(parameter(sum, j, "ripple", "A1"), 0.1, 0.01) << j;
    EXPECT_NEAR(parameter(sum, j, "asymmetry", "a"), 0.15, 0.02) << j;
  }
}

// A bristle with a Stribeck curve of .02 rad/s beside a Stribeck torque of .6: one curve fitted to
// both lies far from either.
TEST(SumFit, FindsBothOfTwoStribeckCurves) {
  const friction::JointSpec joint{{{"lugre", 0, {}}, {"stribeck_peak", 0, {}}}};
  std::vector<std::vector<double>> theta;
  for (const double size : {1.0, 0.8, 0.5})  // Fc, Fs, vs, sigma0, sigma1, sigma2, then Ts, vs, v0
    theta.push_back({10 * size, 13 * size, 0.02, 6000 * size, 30 * size, 10 * size,  //
                     3 * size, 0.6, 0.01});
  const Prepared prepared = noisy_logs(arm_with(joint, theta), 36);
  const auto [sum, parts] = sum_of(prepared);
  for (int j = 0; j < 3; ++j) {
    const auto at = static_cast<std::size_t>(j);
    ASSERT_TRUE(parts[at].stribeck && parts[at].memory == friction::Memory::kBristle) << j;
    EXPECT_NEAR(parameter(sum, j, "lugre", "vs"), 0.02, 0.01) << j;
    EXPECT_NEAR(parameter(sum, j, "lugre", "Fs") / parameter(sum, j, "lugre", "Fc"), 1.3, 0.1) << j;
    EXPECT_NEAR(parameter(sum, j, "stribeck_peak", "vs"), 0.6, 0.15) << j;
  }
}

// Two viscous torques stand for each other: what one would make up for, the other has to show.
TEST(SumFit, HasNoLinearViscousFrictionBesideThatOfAPower) {
  std::vector<std::vector<double>> theta;
  for (const double size : {1.0, 0.8, 0.5})  // Fc, sigma0, Fv, then c, p, v0
    theta.push_back({6 * size, 3000 * size, 0, 3 * size, 0.6, 0.01});
  int linear = 0;
  for (const friction::LvmParts& part :
       parts_found({{{"dahl", 0, {}}, {"viscous_power", 0, {}}}}, theta))
    linear += part.viscous;
  EXPECT_LE(linear, 1);  // of 3
}

// No sum is exact here, so that every parameter makes up for something; and a part that says
// nothing gains more than its standard error in one case of six.
TEST(SumFit, LacksThePartsThatTheTruthLacks) {
  int parts = 0;
  for (const double stiffness : {0.6, 1.7}) {
    std::vector<std::vector<double>> theta;
    for (const double size : {1.0, 0.8, 0.5}) {  // Fc, Fv, then k, alpha of each spring
      const double k = stiffness * size;
      theta.push_back({6 * size, 3 * size, 6000 * k, 0.4, 2000 * k, 0.3, 500 * k, 0.3});
    }
    for (const friction::LvmParts& part : parts_found({{{"prandtl_ishlinskii", 3, {}}}}, theta))
      parts += part.load + part.power_flow + part.asymmetry;
  }
  EXPECT_LE(parts, 9);  // of 18
}

// One spring of .7 mrad, and two of .3 and 30 mrad: the filters of motion and torque round the
// corners, which eight springs imitate.
TEST(SumFit, HasAsManySpringsAsTheTruth) {
  std::vector<std::vector<double>> one, two;
  for (const double size : {1.0, 0.8, 0.5}) {
    one.push_back({7 * size, 3 * size, 1e4 * size, 1});  // Fc, Fv, k, alpha
    two.push_back({7 * size, 3 * size, 1e4 * size, 0.5, 100 * size, 0.5});
  }
  const auto springs = [](int elements, const std::vector<std::vector<double>>& theta) {
    int found = 0;
    for (const friction::LvmParts& of_joint :
         parts_found({{{"prandtl_ishlinskii", elements, {}}}}, theta)) {
      EXPECT_EQ(of_joint.memory, friction::Memory::kBank);
      found += of_joint.elements;
    }
    return found;
  };
  EXPECT_LE(springs(1, one), 4);  // in three joints
  EXPECT_EQ(springs(2, two), 6);
}

// A part may have gained in a trial what the fit that is taken has no need of.
TEST(SumFit, LacksPartsWithoutEffect) {
  std::vector<std::vector<double>> theta;
  for (const double size : {1.0, 0.8, 0.5})  // Fc, Fs, vs, sigma0, sigma1, sigma2
    theta.push_back({6 * size, 7 * size, 0.05, 3000 * size, 5 * size, 2 * size});
  const Prepared prepared = noisy_logs(arm_with({{{"lugre", 0, {}}}}, theta), 60);
  const auto [sum, parts] = sum_of(prepared);
  const friction::Friction& friction = sum.friction;
  for (int j = 0; j < 3; ++j) {
    const auto size_of = [&](std::string_view owner, std::initializer_list<friction::Role> of) {
      double size = 0;
      for (int i = 0; i < friction.model.parameter_count(); ++i) {
        const auto at = static_cast<std::size_t>(i);
        const friction::ParameterRef& p = friction.model.parameters()[at];
        if (p.joint == j && p.owner == owner && std::ranges::count(of, p.info.role) > 0)
          size += std::abs(friction.theta[at]);
      }
      return size;
    };
    using enum friction::Role;
    const friction::LvmParts& has = parts[static_cast<std::size_t>(j)];
    if (has.power_flow) {
      EXPECT_GT(size_of("load_dependent", {kLoadCoefficient, kLoadGrowth}), 0);
    }
    if (has.load) {
      EXPECT_GT(size_of(has.gear_load ? "gear_load" : "load", {kLoadGrowth}), 0);
    }
    if (has.ripples > 0) {
      EXPECT_GT(size_of("ripple", {kAmplitude}), 0);
    }
  }
}

// A cable that slips after .4 rad beside a bristle of 2 mrad, in the joints that have one. A spring
// that begins at the length of a bristle never becomes that soft.
TEST(SumFit, FindsCables) {
  const friction::JointSpec joint{{{"dahl", 0, {}}, {"maxwell_slip", 1, {}}}};
  std::vector<std::vector<double>> theta;
  for (const double size : {1.0, 0.0, 0.5})  // Fc, sigma0, Fv, then K, W
    theta.push_back({6, 3000, 2, 2 * size + 0.01, 0.8 * size + 1e-5});
  const std::vector<friction::LvmParts> parts = parts_found(joint, theta);
  EXPECT_TRUE(parts[0].cable);
  EXPECT_FALSE(parts[1].cable);
  EXPECT_TRUE(parts[2].cable);
}

// Logs that begin while the arm moves do not say how far a cable was bent before, and one that is
// never bent by twice its length does not forget it.
TEST(SumFit, CablesAreBentBeforeALogBegins) {
  const friction::JointSpec joint{{{"dahl", 0, {}}, {"maxwell_slip", 1, {}}}};
  const Arm truth =
      arm_with(joint, {{6, 3000, 2, 4, 2}, {5, 2500, 1.6, 3, 1.2}, {3, 1500, 1, 0.01, 1e-5}});
  std::vector<data::Dataset> logs_cut;
  for (const std::uint64_t seed : {1, 2}) {
    const data::Dataset log =
        make_log(truth, {.seconds = 40, .torque_noise = 0.05, .encoder_noise = 4e-6, .seed = seed});
    logs_cut.push_back(data::rows_of(log, 1000, log.length() - 1000));
  }
  const Prepared prepared = prepare(truth.robot, logs().prepared.options, logs_cut, 2);
  ModelOptions config;
  config.name = "known";
  config.method = Method::kJoint;
  config.laws = {{.law = "dahl", .elements = 4, .modifiers = {}},
                 {.law = "maxwell_slip", .elements = 1, .modifiers = {}}};
  ConventionalFits conventional(prepared);
  const Arm known = fit_model(conventional, config, 1, 2).model.arm;
  EXPECT_NEAR(parameter(known, 0, "maxwell_slip", "K1"), 4, 0.02);
  EXPECT_NEAR(parameter(known, 0, "maxwell_slip", "W1"), 2, 0.01);
  EXPECT_NEAR(parameter(known, 1, "maxwell_slip", "K1"), 3, 0.015);
  EXPECT_NEAR(parameter(known, 1, "maxwell_slip", "W1"), 1.2, 0.006);
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
  const auto [sum, parts] = sum_of(prepared);
  EXPECT_TRUE(parts[0].backlash);
  EXPECT_NEAR(parameter(sum, 0, "backlash", "b"), 3e-4, 3e-5);
  EXPECT_FALSE(parts[1].backlash);
  EXPECT_FALSE(parts[2].backlash);
  EXPECT_EQ(parts[1].ripples, 2);
  EXPECT_NEAR(parameter(sum, 1, "ripple", "n1"), 100, 0.5);
  EXPECT_NEAR(parameter(sum, 1, "ripple", "n2"), 262, 0.5);
  EXPECT_NEAR(parameter(sum, 1, "ripple", "A2"), 0.03, 4e-3);
  for (const auto& p : sum.friction.model.parameters()) {
    if (p.joint != 2 || p.info.role != friction::Role::kAmplitude) continue;
    EXPECT_LT(parameter(sum, 2, "ripple", p.symbol), 3e-3);  // logs without noise show all
  }
}

// A falling Stribeck curve behind a gap: without one that begins open the fit stays in a bank.
TEST(SumFit, FindsLuGreBehindGaps) {
  std::vector<std::vector<double>> theta;
  for (const double Fc : {7.0, 5.0, 3.0})  // Fc, Fs, vs, sigma0, sigma1, sigma2, b
    theta.push_back({Fc, 1.2 * Fc, 0.04, 900 * Fc, 2 * Fc, 0.4 * Fc, 5e-4});
  const Prepared prepared = noisy_logs(arm_with({{{"lugre", 0, {{"backlash", 1}}}}}, theta), 60);
  const auto [sum, parts] = sum_of(prepared);
  for (int j = 0; j < 3; ++j) {
    const friction::LvmParts& of_joint = parts[static_cast<std::size_t>(j)];
    ASSERT_TRUE(of_joint.backlash && of_joint.memory == friction::Memory::kBristle) << j;
    EXPECT_NEAR(parameter(sum, j, "backlash", "b"), 5e-4, 5e-5) << j;
  }
}

// A bank stands for a bristle behind a gap: neither a bristle nor a gap alone betters it.
TEST(SumFit, FindsBristlesBehindGaps) {
  std::vector<std::vector<double>> theta;
  for (const double Fc : {6.0, 5.0, 3.0})  // Fc, sigma0, Fv, mu, b
    theta.push_back({Fc, 2000 * Fc, Fc / 3, 0.01, 2e-4});
  const Prepared prepared = prepared_of(
      arm_with({{{"dahl", 0, {{"load", 1}, {"backlash", 1}}}}}, theta), logs().prepared.options);
  const auto [sum, parts] = sum_of(prepared);
  for (int j = 0; j < 3; ++j) {
    const friction::LvmParts& of_joint = parts[static_cast<std::size_t>(j)];
    EXPECT_EQ(of_joint.memory, friction::Memory::kBristle) << j;
    ASSERT_TRUE(of_joint.backlash) << j;
    EXPECT_NEAR(parameter(sum, j, "backlash", "b"), 2e-4, 2e-5) << j;
  }
}

}  // namespace
}  // namespace fricid::estimate
