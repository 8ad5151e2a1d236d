#include "fricid/estimate/friction/friction_fit.hpp"

#include <gmock/gmock.h>

#include "arm_data.hpp"
#include "flywheel.hpp"
#include "fricid/base/error.hpp"
#include "fricid/base/files.hpp"
#include "fricid/data/artefact.hpp"
#include "fricid/data/log_part.hpp"
#include "fricid/data/training_part.hpp"
#include "fricid/estimate/fit.hpp"
#include "fricid/signals/recording.hpp"
#include "fricid/system/driven_friction.hpp"
#include "temporary_folder.hpp"

namespace fricid::estimate {
namespace {

ModelOptions model(const std::string& name) {
  ModelOptions config;
  config.name = name;
  config.starts = 2;
  return config;
}

std::vector<data::Dataset> logs_of(const Arm& arm, LogOptions options, int count) {
  std::vector<data::Dataset> logs;
  for (int i = 0; i < count; ++i) {
    options.seed = 100 + static_cast<std::uint64_t>(i);
    logs.push_back(make_log(arm, options));
  }
  return logs;
}

double theta_of(const FitReport& report, int joint, const std::string& symbol) {
  const friction::RobotFriction& friction = report.model.arm.friction.model;
  for (std::size_t i = 0; i < friction.parameters().size(); ++i)
    if (friction.parameters()[i].joint == joint && friction.parameters()[i].symbol == symbol)
      return report.model.arm.friction.theta[i];
  return std::nan("");
}

// Reference: the injected truth. Presliding of 1 mrad takes 50 ms at these accelerations, so the
// bristle shows within the 50 Hz of the wide band.
TEST(FitConventional, RecoversLuGre) {
  Arm arm{small_arm(), {}};
  arm.friction = same_law("lugre", {4, 4.6, 0.1, 4000, 5, 2}, arm.robot.n());
  const auto& infos = arm.friction.model.parameters();
  ASSERT_EQ(infos[0].symbol, "Fc");
  ASSERT_EQ(infos[3].symbol, "sigma0");
  const auto logs = logs_of(arm, {}, 3);
  const Prepared prepared = prepare(arm.robot, {}, logs, 2);
  const FitReport report = fit_conventional(prepared, model("lugre"), 1, 2);
  ASSERT_TRUE(report.usable()) << report.message;
  ASSERT_EQ(report.rigid_body.law_factor.size(), arm.robot.n());
  for (int j = 0; j < arm.robot.n(); ++j) {
    SCOPED_TRACE(j);
    const auto true_value = [&](const std::string& symbol) {
      for (std::size_t i = 0; i < infos.size(); ++i)
        if (infos[i].joint == j && infos[i].symbol == symbol) return arm.friction.theta[i];
      return std::nan("");
    };
    const std::pair<const char*, double> tolerances[] = {
        {"Fc", 0.01}, {"Fs", 0.05}, {"sigma0", 0.1}, {"sigma2", 0.02}};
    for (const auto& [symbol, share] : tolerances)
      EXPECT_NEAR(theta_of(report, j, symbol), true_value(symbol), share * true_value(symbol))
          << symbol;
    EXPECT_GT(report.r2[static_cast<std::size_t>(j)], 0.9999);
    EXPECT_NEAR(report.rigid_body.law_factor[j], 1, 0.01);
  }
  // the linear friction of its report stays that of the regression without a law [N m]
  EXPECT_EQ(report.rigid_body.Fc, prepared.rigid_body.Fc);
  EXPECT_EQ(fit_file(report).rigid_body.Fv_se, prepared.rigid_body.Fv_se);
}

// Intervals from logs of different noise and motion hold the truth as often as they say, although
// the filter correlates neighbouring residuals.
TEST(FitConventional, StandardErrorsCoverTheTruth) {
  Arm arm{small_arm(), {}};
  arm.friction = same_law("coulomb_viscous", {4, 2, 0.02}, arm.robot.n());
  ModelOptions config = model("stribeck");
  config.starts = 1;
  int inside = 0, count = 0;
  for (std::uint64_t seed = 0; seed < 10; ++seed) {
    LogOptions options;
    options.torque_noise = 0.5;
    options.seed = 500 + seed;
    const std::vector<data::Dataset> logs{make_log(arm, options)};
    const FitReport report = fit_conventional(prepare(arm.robot, {}, logs, 2), config, 1, 2);
    ASSERT_TRUE(report.usable()) << report.message;
    for (std::size_t j = 0; j < report.joints.size(); ++j) {
      const JointFrictionFit& fit = report.joints[j];
      const double Fv = 2 * std::array{1.0, 0.8, 0.5}[j % 3];
      const std::size_t at = 3;  // Fv of stribeck
      if (!std::isfinite(fit.standard_error[at])) continue;
      inside += std::abs(fit.theta[at] - Fv) < 1.645 * fit.standard_error[at];
      ++count;
    }
  }
  EXPECT_GE(count, 24);
  EXPECT_GE(inside, 0.75 * count);
  EXPECT_LE(inside, count - 1);
}

// Reference: the injected truth. Presliding of .1 mrad passes within samples, and
// within what the filter of the motion takes: no resampling of the log shows by how much stiffness
// and damping are off.
TEST(FitConventional, StandardErrorsHoldWhatTheMotionLost) {
  Arm arm{small_arm(), {}};
  arm.friction = same_law("lugre", {4, 4.6, 0.1, 40000, 20, 2}, arm.robot.n());
  const FitReport report =
      fit_conventional(prepare(arm.robot, {}, logs_of(arm, {}, 3), 2), model("lugre"), 1, 2);
  ASSERT_TRUE(report.usable()) << report.message;
  const std::vector<friction::ParameterRef>& parameters = arm.friction.model.parameters();
  double beyond_blocks = 0, squares = 0;
  for (std::size_t p = 0; p < parameters.size(); ++p) {
    const friction::ParameterRef& place = parameters[p];
    const JointFrictionFit& fit = report.joints[static_cast<std::size_t>(place.joint)];
    const auto i = p - static_cast<std::size_t>(arm.friction.model.parameter_begin(place.joint));
    if (place.symbol != "sigma0" && place.symbol != "sigma1") continue;
    const double error = std::abs(fit.theta[i] - arm.friction.theta[p]);
    squares += std::pow(error / fit.standard_error[i], 2) / 6;
    const double of_blocks = std::sqrt(
        std::max(0.0, std::pow(fit.standard_error[i], 2) - std::pow(fit.motion_error[i], 2)));
    beyond_blocks = std::max(beyond_blocks, error / of_blocks);
  }
  EXPECT_LT(squares, 4);
  EXPECT_GT(beyond_blocks, 5);
}

// Of a joint that slides in one direction the sum of Coulomb friction and offset is known: as in
// the regression, friction takes it.
TEST(FitConventional, SlidingInOneDirectionIsFrictionNotOffset) {
  const Arm arm = coulomb_arm();
  LogOptions noisy;
  noisy.torque_noise = 0.3;
  Prepared prepared = prepare(arm.robot, {}, logs_of(arm, noisy, 2), 2);
  constexpr double kOutOfReach = 0.4;  // [rad/s] of the reversals' filtered torque
  for (signals::Recording& r : prepared.recordings)
    r.use = r.use && (r.narrow.v.array() > kOutOfReach);
  prepared.rigid_body =
      rigid_body_least_squares(prepared.robot, prepared.recordings, prepared.options);
  ASSERT_NE(prepared.rigid_body.prior, "");
  for (const char* law : {"dahl", "stribeck"}) {
    SCOPED_TRACE(law);
    const FitReport report = fit_conventional(prepared, model(law), 1, 2);
    // friction at rest, where no sample is, is all that may be wrong
    for (const Fault& fault : report.faults) {
      EXPECT_STREQ(law, "stribeck");
      EXPECT_TRUE(fault.found.starts_with("friction of ")) << in_words(fault);
    }
    for (int j = 0; j < arm.robot.n(); ++j) {
      const double Fc = arm.friction.theta[static_cast<std::size_t>(3 * j)];
      const JointFrictionFit& joint = report.joints[static_cast<std::size_t>(j)];
      EXPECT_NEAR(theta_of(report, j, "Fc"), Fc, 0.25 * Fc) << j;
      EXPECT_LT(std::abs(joint.offset), 0.25 * Fc) << j;
    }
  }
}

// What is held is not estimated: it has no standard error, and nothing is left to invert.
TEST(FitJointFriction, HeldParametersHaveNoStandardErrors) {
  Arm arm{small_arm(), {}};
  arm.friction = same_law("coulomb_viscous", {4, 2, 0.02}, arm.robot.n());
  const auto logs = logs_of(arm, {}, 1);
  const Prepared prepared = prepare(arm.robot, {}, logs, 2);
  const std::vector<RowMatrix> target{prepared.recordings[0].filtered_tau};
  const JointFrictionData data(prepared.recordings, target, 0, 10);
  const friction::RobotFriction one({{{{"coulomb_viscous", 0, {}}}}});
  FrictionFitOptions options;
  options.held = {0, 1, 2};
  const JointFrictionFit fit = fit_joint_friction(data, one, default_theta(one), options);
  EXPECT_NE(fit.outcome, Outcome::kFailed) << fit.message;
  const std::vector<double> start = default_theta(one);
  for (std::size_t i = 0; i < start.size(); ++i)
    EXPECT_NEAR(fit.theta[i], start[i], 1e-12 * start[i]);
  for (const double error : fit.standard_error) EXPECT_TRUE(std::isnan(error));
  EXPECT_TRUE(fit.correlation.array().isNaN().all());
}

// Only ratios of GMS's alpha count: none has a standard error, while its neighbours do.
TEST(FitJointFriction, WhatOnlyACombinationKnowsHasNoStandardError) {
  Arm arm{small_arm(), {}};
  arm.friction = same_law("dahl", {4, 200, 2}, arm.robot.n());
  const auto logs = logs_of(arm, {}, 1);
  const Prepared prepared = prepare(arm.robot, {}, logs, 2);
  const std::vector<RowMatrix> target{prepared.recordings[0].filtered_tau};
  const JointFrictionData data(prepared.recordings, target, 0, 10);
  const friction::RobotFriction one({{{{"gms", 2, {}}}}});
  FrictionFitOptions options;
  options.evaluations = 200;
  const JointFrictionFit fit = fit_joint_friction(data, one, default_theta(one), options);
  int known = 0;
  for (std::size_t i = 0; i < fit.theta.size(); ++i) {
    const bool alpha = one.parameters()[i].symbol.starts_with("alpha");
    if (alpha) {
      EXPECT_TRUE(std::isnan(fit.standard_error[i])) << one.parameters()[i].symbol;
    }
    known += std::isfinite(fit.standard_error[i]);
  }
  EXPECT_GE(known, 3);
  for (const double r : fit.correlation.reshaped())
    if (!std::isnan(r)) {
      EXPECT_LE(std::abs(r), 1 + 1e-9);
    }
}

// A ripple of any order is found although a descent sees no further than a period over the travel.
TEST(FitConventional, FindsTheOrderOfARipple) {
  Arm arm{small_arm(), {}};
  const friction::LawSpec law{"coulomb_viscous", 0, {{"ripple", 1}}};
  arm.friction.model = friction::RobotFriction(std::vector<friction::JointSpec>(
      static_cast<std::size_t>(arm.robot.n()), friction::JointSpec{{law}}));
  const double orders[] = {37, 61, 90}, phases[] = {0.4, -1.9, 2.5};
  for (int j = 0; j < arm.robot.n(); ++j)
    for (const double value : {4.0, 2.0, 1e-3, orders[j], 0.05, phases[j]})
      arm.friction.theta.push_back(value);
  const auto logs = logs_of(arm, {}, 3);
  const Prepared prepared = prepare(arm.robot, {}, logs, 2);
  ModelOptions rippling = model("simple");
  rippling.modifiers = {"ripple"};
  const FitReport report = fit_conventional(prepared, rippling, 1, 2);
  ASSERT_TRUE(report.usable()) << report.message;
  for (int j = 0; j < arm.robot.n(); ++j) {
    SCOPED_TRACE(j);
    EXPECT_NEAR(theta_of(report, j, "n1"), orders[j], 0.1);
    EXPECT_NEAR(theta_of(report, j, "A1"), 0.05, 0.005);
    EXPECT_NEAR(theta_of(report, j, "phi1"), phases[j], 0.2);
  }
}

// The linear law is the regression's: exact without noise.
TEST(FitConventional, SimpleTakesLinearFrictionFromTheRegression) {
  Arm arm{small_arm(), {}};
  arm.friction = same_law("coulomb_viscous", {4, 2, 1e-3}, arm.robot.n());
  LogOptions options;
  options.substeps = 200;
  const auto logs = logs_of(arm, options, 3);
  const Prepared prepared = prepare(arm.robot, {}, logs, 2);
  const FitReport report = fit_conventional(prepared, model("simple"), 1, 2);
  ASSERT_TRUE(report.usable()) << report.message;
  const auto& theta = arm.friction.theta;
  for (int j = 0; j < arm.robot.n(); ++j) {
    const auto begin = static_cast<std::size_t>(3 * j);
    EXPECT_NEAR(theta_of(report, j, "Fc"), theta[begin], 1e-3 * theta[begin]);
    EXPECT_NEAR(theta_of(report, j, "Fv"), theta[begin + 1], 1e-3 * theta[begin + 1]);
    EXPECT_NEAR(theta_of(report, j, "Fc"), prepared.rigid_body.Fc[j], 1e-12 * theta[begin]);
    EXPECT_NEAR(theta_of(report, j, "Fv"), prepared.rigid_body.Fv[j], 1e-12 * theta[begin]);
    EXPECT_THAT(report.joints[static_cast<std::size_t>(j)].at_bound, testing::IsEmpty());
  }
}

// Friction that does not know the load, and noise: under the measured torque as load the noise
// would explain itself, |tau| sgn(v) with a coefficient near 1.
TEST(FitConventional, FrictionDoesNotExplainItselfAsItsLoad) {
  Arm arm{small_arm(), {}};
  arm.friction = same_law("coulomb_viscous", {4, 2, 1e-3}, arm.robot.n());
  LogOptions options;
  options.torque_noise = 5;
  const auto logs = logs_of(arm, options, 2);
  const Prepared prepared = prepare(arm.robot, {}, logs, 2);
  const FitReport report = fit_conventional(prepared, model("load_dependent"), 1, 2);
  for (int j = 0; j < arm.robot.n(); ++j) EXPECT_LT(theta_of(report, j, "mu_m"), 0.05) << j;
}

// A spike of static friction about v = 0 explains reversals that a law cannot describe, by hundreds
// of newton metres.
TEST(FitConventional, StaticFrictionIsAtMostSomeTimesThatOfSliding) {
  Arm arm{small_arm(), {}};
  arm.friction = same_law("coulomb_viscous", {4, 2, 1e-3}, arm.robot.n());
  LogOptions options;
  options.torque_noise = 0.3;
  options.encoder_noise = 1e-5;
  const Prepared prepared = prepare(arm.robot, {}, logs_of(arm, options, 2), 2);
  for (const char* law : {"stribeck", "lugre", "gms"}) {
    const FitReport report = fit_conventional(prepared, model(law), 1, 2);
    for (int j = 0; j < arm.robot.n(); ++j)
      EXPECT_LT(theta_of(report, j, "Fs"), 3.5 * theta_of(report, j, "Fc")) << law << ", " << j;
  }
}

std::string saved(const FitReport& report) { return data::to_json(fit_file(report)); }

TEST(FitConventional, ReportIsTheSameBytesForAnyNumberOfJobs) {
  Arm arm{small_arm(), {}};
  arm.friction = same_law("stribeck", {4, 5, 0.1, 2, 1e-3}, arm.robot.n());
  LogOptions options;
  options.torque_noise = 0.1;
  options.encoder_noise = 4e-6;
  const auto logs = logs_of(arm, options, 2);
  const auto fitted = [&](int jobs) {
    return saved(fit_conventional(prepare(arm.robot, {}, logs, jobs), model("dahl"), 3, jobs));
  };
  const std::string one = fitted(1);
  EXPECT_THAT(one, testing::HasSubstr("\"format\": \"fricid.fit/2\""));
  EXPECT_EQ(fitted(2), one);
  EXPECT_EQ(fitted(3), one);
}

// Models that begin with the same law, whatever their names and methods.
TEST(ConventionalFits, AreThoseOfTheirLawsAndSeeds) {
  Arm arm{small_arm(), {}};
  arm.friction = same_law("stribeck", {4, 5, 0.1, 2, 1e-3}, arm.robot.n());
  const Prepared prepared = prepare(arm.robot, {}, logs_of(arm, {}, 2), 2);
  ConventionalFits fits(prepared);
  ModelOptions other = model("dahl");
  other.name = "by windows";
  other.law = "dahl";
  for (const auto& [options, seed] :
       {std::pair{model("dahl"), 1}, {other, 1}, {model("stribeck"), 1}, {model("dahl"), 2}})
    EXPECT_EQ(saved(fits.fit(options, seed, 2)),
              saved(fit_conventional(prepared, options, seed, 2)));
}

TEST(FitConventional, NamesAnUnknownLaw) {
  const Arm arm{small_arm(), same_law("coulomb_viscous", {4, 2, 1e-3}, 3)};
  Prepared prepared;
  prepared.robot = arm.robot;
  try {
    fit_conventional(prepared, model("stribek"), 1, 1);
    FAIL();
  } catch (const UserError& error) {
    EXPECT_THAT(error.what(), testing::HasSubstr("unknown law \"stribek\""));
  }
}

// The second period of a motion again and again with other noise, 44 minutes in all.
data::Dataset long_log(const Arm& arm) {
  LogOptions options;
  options.seconds = 24;
  const data::Dataset two = make_log(arm, options);
  constexpr int kPeriods = 220;
  const int period = two.length() / 2;
  data::Dataset log = data::rows_of(two, period, period);
  log.t = Eigen::VectorXd::LinSpaced(kPeriods * period, 0, (kPeriods * period - 1) * log.dt());
  log.q = log.q.replicate(kPeriods, 1).eval();
  log.tau = log.tau.replicate(kPeriods, 1).eval();
  Rng noise(1, 0);
  for (double& tau : log.tau.reshaped()) tau += 0.3 * noise.normal();
  for (double& q : log.q.reshaped()) q += 2e-6 * noise.normal();
  return log;
}

// A fit to a long log works on pieces of it, finds what all of it gives, and says so.
TEST(FitConventional, ALongLogIsFittedInPart) {
  const Arm arm = coulomb_arm(5e-3);
  const std::vector<data::Dataset> logs{long_log(arm)};
  const Prepared prepared = prepare(arm.robot, {}, logs, 2);
  int samples = 0;
  for (const signals::Recording& r : prepared.recordings) samples += r.length();
  EXPECT_LE(samples, data::kMostSamples);
  EXPECT_GE(samples, 0.9 * data::kMostSamples);
  const FitReport report = fit_conventional(prepared, model("simple"), 1, 2);
  EXPECT_THAT(report.brief(), testing::HasSubstr("fitted to 1280 of 2640 s, 64 pieces"));
  ASSERT_TRUE(fit_file(report).fitted_to);
  EXPECT_EQ(fit_file(report).fitted_to->of_seconds, 2640);

  const std::vector<signals::Recording> whole{signals::make_recording(logs[0], 10)};
  const RigidBodyFit &part = prepared.rigid_body,
                     all = rigid_body_least_squares(prepared.robot, whole, prepared.options);
  for (int j = 0; j < arm.robot.n(); ++j) {
    SCOPED_TRACE(j);
    EXPECT_LT(part.rows_total[static_cast<std::size_t>(j)],
              0.5 * all.rows_total[static_cast<std::size_t>(j)]);
    EXPECT_NEAR(part.Fc[j], all.Fc[j], 4 * part.Fc_se[j]);
    EXPECT_NEAR(part.Fv[j], all.Fv[j], 4 * part.Fv_se[j]);
    EXPECT_LT(part.Fc_se[j], 2 * all.Fc_se[j]);
  }
  for (Eigen::Index i = 0; i < part.base.size(); ++i)
    EXPECT_NEAR(part.base[i], all.base[i], 4 * part.base_se[i])
        << part.base_names[static_cast<std::size_t>(i)];
}

/// A wheel that swings for 6 s and stands for 3 s in turn, its encoder in steps of 10 urad.
struct RestingWheel {
  static constexpr double kStep = 1e-5, kFc = 6, kFv = 2, kInertia = 0.3;
  std::vector<bool> stands;
  data::Dataset log;

  /// @param sigma0  of its Dahl friction [N m/rad]
  /// @param wander  friction within +-Fc at rest by reasons that no log shows
  /// @param trembles  by 1 urad at rest, about the edge between two steps of the encoder
  RestingWheel(double sigma0, bool wander, bool trembles = false) {
    const double dt = 0.004, w = 2 * std::numbers::pi / 3;
    const int T = 9000;
    log.name = "wheel";
    log.joint_names = {"joint"};
    log.rate_hz = 1 / dt;
    log.t = Eigen::VectorXd::LinSpaced(T, 0, (T - 1) * dt);
    log.q.resize(T, 1);
    log.tau.resize(T, 1);
    RowMatrix q(T, 1), v(T, 1), a(T, 1);
    for (int k = 0; k < T; ++k) {
      const double phase = std::fmod(log.t[k], 9.0);
      stands.push_back(phase >= 6);
      const double x = w * std::min(phase, 6.0), size = stands.back() ? 0 : 1;
      q(k, 0) = 0.5 * (1 - std::cos(x)) + 0.1 * (1 - std::cos(4 * x));
      v(k, 0) = size * w * (0.5 * std::sin(x) + 0.4 * std::sin(4 * x));
      a(k, 0) = size * w * w * (0.5 * std::cos(x) + 1.6 * std::cos(4 * x));
      if (trembles) {
        constexpr double kTremble = 1e-6, kOften = 5;
        q(k, 0) += kStep / 2 + kTremble * std::sin(kOften * log.t[k]);
        v(k, 0) += kTremble * kOften * std::cos(kOften * log.t[k]);
      }
    }
    const friction::Friction friction{friction::RobotFriction({{{{"dahl", 0, {}}}}}),
                                      {kFc, sigma0, kFv}};
    const RowMatrix tau_f = drive_friction(friction, dt, q, v, v, RowMatrix()).tau_f;
    Rng noise(1, 0);
    for (int k = 0; k < T; ++k) {
      const double f = wander && stands[static_cast<std::size_t>(k)]
                           ? kFc * std::sin(0.7 * log.t[k])
                           : tau_f(k, 0);
      log.q(k, 0) = kStep * std::round(q(k, 0) / kStep);
      log.tau(k, 0) = kInertia * a(k, 0) + f + 0.05 * noise.normal();
    }
  }
};

// Under a bristle that no encoder sees, the torque of a rest is whatever the controller left.
TEST(Prepare, LeavesOutRestsOfStiffFriction) {
  const RestingWheel wheel(1e6, true);
  const Prepared prepared =
      prepare(test::flywheel(RestingWheel::kInertia, 1).robot, {}, {&wheel.log, 1}, 1);
  int used = 0;
  for (int k = 0; k < wheel.log.length(); ++k)
    used += wheel.stands[static_cast<std::size_t>(k)] && prepared.recordings[0].use(k, 0);
  EXPECT_LT(used, 300);  // of 3000: edges, where filters settle
  const FitReport report = fit_conventional(prepared, model("dahl"), 1, 1);
  EXPECT_NEAR(theta_of(report, 0, "Fc"), RestingWheel::kFc, 0.01 * RestingWheel::kFc);
  EXPECT_NEAR(theta_of(report, 0, "Fv"), RestingWheel::kFv, 0.02 * RestingWheel::kFv);
}

// A rest under a soft bristle tells how it was left.
TEST(Prepare, KeepsRestsOfSoftFriction) {
  const RestingWheel wheel(3000, false);
  const Prepared prepared =
      prepare(test::flywheel(RestingWheel::kInertia, 1).robot, {}, {&wheel.log, 1}, 1);
  int left_out = 0;
  for (int k = 100; k < wheel.log.length() - 100; ++k)
    left_out += wheel.stands[static_cast<std::size_t>(k)] && !prepared.recordings[0].use(k, 0);
  EXPECT_EQ(left_out, 0);
}

// A step to and fro is ten times the tremble that makes it: a bristle that it drove would slip by
// that, and the fit took the joint for a softer one.
TEST(Prepare, LeavesOutRestsThatTheEncoderSeesInSteps) {
  constexpr double kSigma0 = 25'000;
  const RestingWheel wheel(kSigma0, false, true);
  const Prepared prepared =
      prepare(test::flywheel(RestingWheel::kInertia, 1).robot, {}, {&wheel.log, 1}, 1);
  int used = 0;
  for (int k = 0; k < wheel.log.length(); ++k)
    used += wheel.stands[static_cast<std::size_t>(k)] && prepared.recordings[0].use(k, 0);
  EXPECT_LT(used, 300);  // of 3000
  const FitReport report = fit_conventional(prepared, model("dahl"), 1, 1);
  EXPECT_NEAR(theta_of(report, 0, "Fc"), RestingWheel::kFc, 0.01 * RestingWheel::kFc);
  const RestingWheel still(kSigma0, false);
  const double sigma0 =
      theta_of(fit_conventional(
                   prepare(test::flywheel(RestingWheel::kInertia, 1).robot, {}, {&still.log, 1}, 1),
                   model("dahl"), 1, 1),
               0, "sigma0");
  EXPECT_NEAR(theta_of(report, 0, "sigma0"), sigma0, 0.05 * sigma0);
}

TEST(Prepare, SaysWhatBringsLogsToOneRate) {
  const Arm arm = coulomb_arm();
  std::vector<data::Dataset> logs = logs_of(arm, {}, 2);
  logs[0].name = "train_0";
  logs[1].name = "train_1";
  const double rate = logs[0].rate_hz;
  const auto error = [&](double factor) -> std::string {
    logs[1].rate_hz = factor * rate;
    try {
      prepare(arm.robot, {}, logs, 2);
    } catch (const UserError& e) {
      return e.what();
    }
    return "no error";
  };
  EXPECT_EQ(error(1), "no error");
  EXPECT_THAT(error(2), testing::HasSubstr("one rate in a scene: filter train_1 and keep one row "
                                           "in 2, or fit it in a scene of its own"));
  EXPECT_THAT(error(0.25), testing::HasSubstr("filter train_0 and keep one row in 4"));
  EXPECT_THAT(error(0.7), testing::HasSubstr("resample one of them"));
  EXPECT_THAT(error(1.005), testing::HasSubstr("give both even times of"));
  EXPECT_EQ(error(1.0001), "no error");  // two clocks
}

}  // namespace
}  // namespace fricid::estimate
