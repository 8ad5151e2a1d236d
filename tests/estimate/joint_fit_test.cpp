// Friction and rigid body fitted together, on logs of a small arm.
#include "fricid/estimate/torque/joint_fit.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "fricid/estimate/predict_torque.hpp"
#include "fricid/estimate/torque/carry_over.hpp"
#include "fricid/estimate/torque/sum_fit.hpp"
#include "fricid/estimate/torque/sum_start.hpp"
#include "joint_logs.hpp"

namespace fricid::estimate {
namespace {

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

// A bank of springs stands for a bristle that no spring is by less static friction than the bristle
// has, at speeds that the motion, a slow Fourier series, hardly has. The pull takes a good part of
// that back.
TEST(ArmTorqueFit, StaticFrictionIsPulledToThatOfSliding) {
  const std::vector<std::vector<double>> theta{{6, 3000, 3}, {4.8, 2400, 2.4}, {3, 1500, 1.5}};
  const Prepared prepared = noisy_logs(arm_with({{{"dahl", 0, {}}}}, theta), 12, true);
  const JointFits fits(prepared, logs().windows, 2);
  const Arm start = fits.start(friction::JointSpec{{{"gms", 4, {}}}});
  const ArmTorqueData data(prepared.robot, prepared.recordings, prepared.options.cutoff_hz);
  const auto missing = [&](bool pull, int j) {
    ArmTorqueOptions options;
    options.nominal = prepared.robot.pi;
    options.pull_static = pull;
    const Arm arm = fit_arm_torque(data, start, options, 2).arm;
    return 1 - parameter(arm, j, "gms", "Fs") / parameter(arm, j, "gms", "Fc");
  };
  for (int j = 0; j < 3; ++j) {
    const double alone = missing(false, j), pulled = missing(true, j);
    EXPECT_GT(alone, 0.05) << j;
    EXPECT_LT(pulled, 0.7 * alone) << j;
  }
}

// Draws differ from the fit as the fit does from the truth.
TEST(ArmErrors, AreThoseOfTheFit) {
  const std::vector<std::vector<double>> theta{{6, 3000, 3}, {4.8, 2400, 2.4}, {3, 1500, 1.5}};
  const Arm truth = arm_with({{{"dahl", 0, {}}}}, theta);
  const Prepared prepared = prepared_of(truth, logs().prepared.options,
                                        {.seconds = 24, .torque_noise = 1, .repeats = false});
  const JointFits fits(prepared, logs().windows, 2);
  const Arm fitted =
      fits.on_torque(fits.start(truth.friction.model.joints()), JointFits::Rows::kAll).arm;
  const ArmErrors errors = fits.errors_of(fitted, 39, 1);
  const std::vector<Arm>& draws = errors.draws;
  ASSERT_EQ(draws.size(), 39u);
  double squares = 0;
  for (std::size_t i = 0; i < 9; ++i) {
    double mean = 0, variance = 0;
    for (const Arm& draw : draws) mean += draw.friction.theta[i] / 39;
    for (const Arm& draw : draws) variance += std::pow(draw.friction.theta[i] - mean, 2) / 38;
    EXPECT_LT(std::sqrt(variance), 0.05 * fitted.friction.theta[i]) << i;
    const double z = (fitted.friction.theta[i] - truth.friction.theta[i]) / std::sqrt(variance);

    squares += z * z / 9;
  }
  EXPECT_GT(squares, 0.3);
  EXPECT_LT(squares, 3);
  EXPECT_EQ(JointFits(prepared, logs().windows, 1).errors_of(fitted, 39, 1).draws[38].robot.pi,
            draws[38].robot.pi);
}

// What a model misses in a motion it misses in every recording of it, which says nothing new.
TEST(ArmErrors, DoNotShrinkWhereAMotionIsRepeated) {
  const Prepared& prepared = logs().prepared;
  const std::vector<signals::Recording> once(prepared.recordings.begin(),
                                             prepared.recordings.begin() + 1);
  const std::vector<signals::Recording> twice{once[0], once[0]};
  ArmTorqueOptions options;
  options.nominal = prepared.robot.pi;
  const double cutoff_hz = prepared.options.cutoff_hz;
  const ArmTorqueData of_once(prepared.robot, once, cutoff_hz),
      of_twice(prepared.robot, twice, cutoff_hz);
  const Arm start =
      JointFits(prepared, logs().windows, 2).start(friction::JointSpec{{{"dahl", 0, {}}}});
  const Arm fitted = fit_arm_torque(of_once, start, options, 2).arm;
  const auto errors = [&](const ArmTorqueData& data) -> Eigen::VectorXd {
    const MotionErrors motion(data.recordings(), cutoff_hz, 2);
    return arm_errors(data, motion, fitted, options, 0, 1, 2).root.rowwise().norm();
  };
  const Eigen::VectorXd alone = errors(of_once), both = errors(of_twice);
  ASSERT_GT(alone.size(), 0);
  int stated = 0;
  for (Eigen::Index i = 0; i < alone.size(); ++i) {
    EXPECT_GE(both[i], 0.9 * alone[i]) << i;  // as independent blocks 0.7; pulls weigh half as much
    stated += alone[i] > 0;
  }
  EXPECT_GT(stated, 9);
}

// A friction of nearly nothing is not known to nearly nothing: beside a bristle, 1e-5 N m and
// a tenth of it are the same to the torque.
TEST(ArmErrors, OfWhatTheTorqueLeavesOpenAreNotOfItsSize) {
  const std::vector<std::vector<double>> theta{{6, 3000, 3}, {4.8, 2400, 2.4}, {3, 1500, 1.5}};
  const Arm truth = arm_with({{{"dahl", 0, {}}}}, theta);
  const Prepared prepared = prepared_of(truth, logs().prepared.options, {.torque_noise = 0.3});
  const JointFits fits(prepared, logs().windows, 2);
  const friction::JointSpec two{{{"dahl", 0, {}}, {"coulomb_viscous", 0, {}}}};
  Arm fitted = fits.on_torque(fits.start(two), JointFits::Rows::kAll).arm;
  const auto index = [&](int j, const char* law) {
    return friction::find_parameter(fitted.friction.model, j, law, "Fc");
  };
  for (int j = 0; j < 3; ++j) {
    const auto own = static_cast<std::size_t>(index(j, "dahl")),
               other = static_cast<std::size_t>(index(j, "coulomb_viscous"));
    fitted.friction.theta[own] += fitted.friction.theta[other] - 1e-5;
    fitted.friction.theta[other] = 1e-5;
  }
  const ArmErrors errors = fits.errors_of(fitted, 0, 1);
  for (int j = 0; j < 3; ++j) {
    const auto error = [&](const char* law) {
      return errors.root.row(fitted.robot.pi.size() + index(j, law)).norm();
    };
    EXPECT_GT(error("coulomb_viscous"), 5e-3) << j;
    EXPECT_LT(error("coulomb_viscous"), 1) << j;
    EXPECT_LT(error("dahl"), 0.05 * parameter(fitted, j, "dahl", "Fc")) << j;
  }
}

TEST(ArmErrors, OfSharesAreThoseOfASumOfOne) {
  const Prepared& prepared = logs().prepared;
  const JointFits fits(prepared, logs().windows, 2);
  const Arm fitted =
      fits.on_torque(fits.start(friction::JointSpec{{{"gms", 3, {}}}}), JointFits::Rows::kAll).arm;
  const ArmErrors errors = fits.errors_of(fitted, 0, 1);
  const std::vector<std::vector<std::size_t>> shares = friction::shares(fitted.friction.model);
  ASSERT_EQ(shares.size(), 3u);
  for (const std::vector<std::size_t>& law : shares) {
    Eigen::RowVectorXd sum = Eigen::RowVectorXd::Zero(errors.root.cols());
    double largest = 0;
    for (const std::size_t i : law) {
      const auto row = errors.root.row(fitted.robot.pi.size() + static_cast<Eigen::Index>(i));
      sum += row;
      largest = std::max(largest, row.norm());
    }
    ASSERT_GT(largest, 0);
    EXPECT_LT(sum.norm(), 1e-9 * largest);
  }
}

// A share that is hardly there stays one that a model file may have.
TEST(JointFits, JudgeSharesOfASumOfOneWithinTheirBounds) {
  const JointFits fits(logs().prepared, logs().windows, 2);
  Arm arm = fits.start(friction::JointSpec{{{"gms", 3, {}}}});
  const std::vector<std::size_t> law = friction::shares(arm.friction.model)[0];
  arm.friction.theta[law[0]] = 1e-6;
  arm.friction.theta[law[1]] = 30;
  arm.friction.theta[law[2]] = 10;
  const std::vector<double> theta = fits.judged("gms", arm, 0).arm.friction.theta;
  EXPECT_EQ(theta[law[0]], 1e-6);
  EXPECT_NEAR(theta[law[1]], 0.75, 1e-6);
  EXPECT_NEAR(theta[law[2]], 0.25, 1e-6);
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

// Most of the torque is friction that grows with it: too little load makes a fit predict too much.
TEST(JointFits, TheLoadOfFrictionIsItsOwn) {
  std::vector<std::vector<double>> theta;
  for (const double size : {1.0, 0.8, 0.5})  // Fc, sigma0, Fv, mu
    theta.push_back({12 * size, 6000 * size, 10 * size, 0.02 / size});
  const Arm truth = arm_with({{{"dahl", 0, {{"load", 1}}}}}, theta);
  const Prepared prepared = noisy_logs(truth, 12);
  JointFits fits(prepared, logs().windows, 2);
  const Arm start = fits.start(truth.friction.model.joints());
  const Arm fitted = fits.under_own_load(fits.on_torque(start, JointFits::Rows::kTraining).arm,
                                         JointFits::Rows::kAll)
                         .arm;
  for (int j = 0; j < 3; ++j)
    for (const auto& [owner, symbol] : {std::pair("load", "mu"), {"dahl", "Fc"}, {"dahl", "Fv"}})
      EXPECT_NEAR(parameter(fitted, j, owner, symbol) / parameter(truth, j, owner, symbol), 1, 0.02)
          << j << ", " << symbol;
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
  EXPECT_LT(data.load_gain(fitted, 1), 0.95);
  for (const signals::Recording& r : steep.recordings)
    EXPECT_LT(predict_torque(fitted, r, steep.options.cutoff_hz).cwiseAbs().maxCoeff(),
              3 * r.filtered_tau.cwiseAbs().maxCoeff());
}

// Fits are judged by the joints that move in what is held out; of one that rests in all of it
// nothing is held out, of one that rests in all logs nothing is known.
TEST(JointFits, AJointThatRestsDoesNotJudge) {
  for (const bool everywhere : {false, true}) {
    Prepared prepared = logs().prepared;
    for (std::size_t i = 0; i < prepared.recordings.size(); ++i)
      if (everywhere || i + 1 == prepared.recordings.size())
        prepared.recordings[i].use.col(1).setConstant(false);
    const JointFits fits(prepared, logs().windows, 2);
    const Arm start = fits.start(friction::JointSpec{{{"coulomb_viscous", 0, {}}}});
    EXPECT_TRUE(std::isfinite(fits.held_out_torque(start)));
    EXPECT_GT(fits.held_out_torque(start), 0);
  }
}

// A narrow prior keeps friction where it is, a wide one leaves it to the data; waves are never in
// it.
TEST(JointFits, ArePulledToAPrior) {
  const Arm prior = sibling(1.3);
  for (const double sd : {1e-4, 10.0}) {
    JointFits fits(logs().prepared, logs().windows, 2);
    fits.take_prior(ArmPrior{prior, sd});
    const Arm fitted = fits.on_torque(prior, JointFits::Rows::kAll).arm;
    for (int j = 0; j < 3; ++j) {
      const double known = parameter(prior, j, "dahl", "Fc"),
                   truth = parameter(logs().truth, j, "dahl", "Fc");
      EXPECT_NEAR(parameter(fitted, j, "dahl", "Fc"), sd < 1 ? known : truth, 0.1 * truth);
      EXPECT_GT(parameter(fitted, j, "ripple", "A1"), 0.03);
      EXPECT_LT(parameter(fitted, j, "ripple", "A1"), sd > 1 ? 0.05 : 1);
    }
  }
}

// A joint whose torque hardly varies: growth with the load would be its Coulomb friction.
TEST(JointFits, LoadIsLookedForWhereTheTorqueVaries) {
  Prepared prepared = logs().prepared;
  for (signals::Recording& r : prepared.recordings)
    r.filtered_tau.col(1) = (40 + 0.1 * r.filtered_tau.col(1).array().sin()).matrix();
  const JointFits fits(prepared, logs().windows, 2);
  for (int j = 0; j < 3; ++j) {
    EXPECT_EQ(fits.can_show(friction::SumPart::kPowerFlow, j), j != 1) << j;
    EXPECT_EQ(fits.all_parts()[static_cast<std::size_t>(j)].load, j != 1) << j;
  }
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

// A cable that was tried and not taken leaves no rows without their means.
TEST(JointFits, RowsCountInFullWithoutACable) {
  JointFits fits(logs().prepared, logs().windows, 2);
  const Arm plain = fits.start(friction::JointSpec{{{"coulomb_viscous", 0, {}}}});
  Arm cable = arm_with({{{"maxwell_slip", 1, {}}}}, {{5, 50}, {5, 50}, {5, 50}});
  const auto rms = [&] {
    return std::vector{fits.residual_rms(plain, 0), fits.residual_rms(plain, 1),
                       fits.residual_rms(plain, 2)};
  };
  const std::vector<double> before = rms();
  fits.take_springs_of(cable);
  EXPECT_LT(rms()[1], before[1]);  // less the mean of every recording
  fits.take_springs_of(plain);
  EXPECT_EQ(rms(), before);
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
      arm = fits.on_torque(arm, JointFits::Rows::kTraining, WaveSearch::kNone).arm;
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
        .on_torque(from ? carried_over(*from, start) : start, JointFits::Rows::kTraining,
                   from ? WaveSearch::kNone : WaveSearch::kGears)
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

}  // namespace
}  // namespace fricid::estimate
