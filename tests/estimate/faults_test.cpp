// Fits to logs and robots as users have them: right, or said not to be trusted.
#include <gmock/gmock.h>

#include <Eigen/QR>
#include <cmath>
#include <numbers>

#include "fit_of_logs.hpp"
#include "fricid/dynamics/base_parameters.hpp"
#include "fricid/estimate/predict_torque.hpp"
#include "fricid/estimate/rigid_body/identifiability.hpp"

namespace fricid::estimate {
namespace {

using testing::HasSubstr;

// Reference: the injected truth. An armature held at the zero of the file would leave most of the
// torque to friction.
TEST(Faults, WhatTheUrdfLeavesOutIsIdentified) {
  const Arm arm = coulomb_arm(5e-3);
  LogOptions options;
  options.torque_noise = 0.2;
  const FitReport report = fit(as_published(arm.robot), {make_log(arm, options)});
  EXPECT_TRUE(report.usable()) << text_of(report.faults);
  for (int j = 0; j < arm.robot.n(); ++j) {
    SCOPED_TRACE(j);
    const JointFrictionFit& joint = report.joints[static_cast<std::size_t>(j)];
    const double scale = std::array{1.0, 0.8, 0.5}[static_cast<std::size_t>(j)];
    EXPECT_GT(report.r2[static_cast<std::size_t>(j)], 0.99);
    EXPECT_NEAR(joint.theta[0], 4 * scale, 0.03 * 4 * scale);
    EXPECT_NEAR(joint.theta[1], 2 * scale, 0.05 * 2 * scale);
  }
}

// Reference: ordinary least squares in its own words, on every sample that slides: rigid body in
// base parameters, sign of the velocity, velocity.
TEST(Faults, SimpleIsPlainLeastSquares) {
  Arm arm{small_arm(), {}};
  arm.friction = same_law("lugre", {4, 4.4, 0.05, 8000, 40, 2}, arm.robot.n());
  LogOptions options;
  options.torque_noise = 0.3;
  options.encoder_noise = 4e-6;
  const std::vector<data::Dataset> logs{make_log(arm, options)};
  const FitReport report = fit(arm.robot, logs);
  ASSERT_TRUE(report.usable()) << text_of(report.faults);

  const dynamics::RobotModel& robot = arm.robot;
  const int n = robot.n(), p = robot.parameter_count();
  const std::vector<int> columns = dynamics::base_parameters(robot).columns;
  const auto b = static_cast<Eigen::Index>(columns.size());
  const signals::Recording s = signals::make_recording(logs[0], 10);
  constexpr double kSlides = 0.1;  // [rad/s]
  std::vector<Eigen::RowVectorXd> rows;
  std::vector<double> right;
  dynamics::Workspace<double> ws(robot);
  Eigen::MatrixXd Y(n, p);
  for (int k = 0; k < s.length(); ++k) {
    const auto row = [&](const RowMatrix& x) {
      return std::span<const double>(x.row(k).data(), static_cast<std::size_t>(n));
    };
    dynamics::regressor(robot, ws, row(s.narrow.q), row(s.narrow.v), row(s.narrow.a), Y);
    for (int j = 0; j < n; ++j) {
      if (!s.use(k, j) || std::abs(s.narrow.v(k, j)) < kSlides) continue;
      Eigen::RowVectorXd x = Eigen::RowVectorXd::Zero(b + 3 * n);
      for (Eigen::Index c = 0; c < b; ++c) x[c] = Y(j, columns[static_cast<std::size_t>(c)]);
      x[b + j] = s.narrow.v(k, j) > 0 ? 1 : -1;
      x[b + n + j] = s.narrow.v(k, j);
      x[b + 2 * n + j] = 1;
      rows.push_back(x);
      right.push_back(s.filtered_tau(k, j));
    }
  }
  Eigen::MatrixXd X(static_cast<Eigen::Index>(rows.size()), b + 3 * n);
  for (std::size_t i = 0; i < rows.size(); ++i) X.row(static_cast<Eigen::Index>(i)) = rows[i];
  const Eigen::VectorXd plain = X.colPivHouseholderQr().solve(
      Eigen::Map<Eigen::VectorXd>(right.data(), static_cast<Eigen::Index>(right.size())));
  for (int j = 0; j < n; ++j) {
    SCOPED_TRACE(j);
    const JointFrictionFit& joint = report.joints[static_cast<std::size_t>(j)];
    EXPECT_NEAR(joint.theta[0], plain[b + j], 0.03 * plain[b + j]);
    EXPECT_NEAR(joint.theta[1], plain[b + n + j], 0.03 * plain[b + n + j]);
    EXPECT_EQ(joint.theta[2], 0.01);  // [rad/s], above three deviations of this log's velocity
    EXPECT_GT(joint.standard_error[0], 0);
    EXPECT_GT(joint.standard_error[1], 0);
  }
}

TEST(Faults, CoarsePositionsSmoothSimpleFurther) {
  const Arm arm = coulomb_arm(5e-3);
  LogOptions options;
  options.encoder_noise = 2e-4;
  const std::vector<data::Dataset> logs{make_log(arm, options)};
  const Prepared prepared = prepare(arm.robot, {}, logs, 2);
  // oracle: spread of the velocity's noise, log less clean log
  const signals::Recording noisy = signals::make_recording(logs[0], 10),
                           clean = signals::make_recording(make_log(arm, {}), 10);
  const Eigen::ArrayXd noise = (noisy.wide.v - clean.wide.v).col(0).array();
  const double sd = std::sqrt(noise.square().mean());
  EXPECT_NEAR(smoothing_speed(prepared.robot, prepared.recordings, 10, 0), 3 * sd, 0.1 * 3 * sd);
}

TEST(Faults, SlidingJointsAreSmoothedOverATenth) {
  Arm arm = coulomb_arm(5e-3);
  const std::vector<data::Dataset> logs{make_log(arm, {})};
  const Prepared prepared = prepare(arm.robot, {}, logs, 2);
  EXPECT_EQ(smoothing_speed(arm.robot, prepared.recordings, 10, 1), 0.01);
  arm.robot.joints[1].type = dynamics::JointType::kPrismatic;
  EXPECT_LT(smoothing_speed(arm.robot, prepared.recordings, 10, 1), 0.01);
  EXPECT_GE(smoothing_speed(arm.robot, prepared.recordings, 10, 1), 0.001);
}

TEST(Faults, AJointThatRestsIsNamedWithTheWayToHoldItOut) {
  const Arm arm = coulomb_arm(5e-3);
  data::Dataset log = make_log(arm, {});
  log.q.col(2).setConstant(0.25);
  const FitReport report = fit(arm.robot, {log});
  EXPECT_FALSE(report.usable());
  const std::string text = text_of(report.faults);
  EXPECT_THAT(text, HasSubstr("j3: moves by 0 rad in all training data"));
  EXPECT_THAT(text, HasSubstr("exclude it: [robot] hold = [\"j3\"]"));
}

// A joint that a controller shakes at 20 Hz while it should stand.
TEST(Faults, MeasuredMotionThatChattersIsNamed) {
  const Arm arm = coulomb_arm(5e-3);
  for (const double amplitude : {0.0, 1e-3}) {
    data::Dataset log = make_log(arm, {});
    const int stands = log.length() / 2;
    for (int k = stands; k < log.length(); ++k)
      log.q(k, 2) = log.q(stands, 2) + amplitude * std::sin(2 * std::numbers::pi * 20 * log.t[k]);
    const std::string text = text_of(fit(arm.robot, {log}).faults);
    EXPECT_EQ(text.find("j3: its measured motion chatters in 6 of 12 s: up to 40 reversals") !=
                  std::string::npos,
              amplitude > 0)
        << text;
  }
}

TEST(Faults, InertiaBelowTheStatedArmatureIsNamed) {
  const Arm arm = coulomb_arm(5e-3);
  const std::vector<data::Dataset> logs{make_log(arm, {})};
  ASSERT_TRUE(fit(arm.robot, logs).usable());
  dynamics::RobotModel robot = arm.robot;
  robot.pi[robot.armature_begin() + 2] = 1;
  const std::string text = text_of(fit(robot, logs).faults);
  EXPECT_THAT(text,
              testing::ContainsRegex(
                  "j3: inertia of 0\\.1[0-9]* kg m.2, less than half of the armature alone that "
                  "is stated for it, 1"));
  EXPECT_THAT(text, HasSubstr("correct the armature"));
}

// Beyond the gear there is no rotor.
TEST(Faults, TorqueBeyondTheGearHasNoArmature) {
  const Arm arm = coulomb_arm(5e-3);
  dynamics::RobotModel robot = arm.robot;
  robot.pi[robot.armature_begin() + 2] = 1;
  for (const char* kind : {"motor_torque", "link_torque"}) {
    data::Dataset log = make_log(arm, {});
    log.source = fmt::format("import a.csv, tau from {}", kind);
    EXPECT_EQ(text_of(fit(robot, {log}).faults).find("armature") == std::string::npos,
              std::string_view(kind) == "link_torque");
  }
}

TEST(Faults, FrictionThatOutgrowsItsOwnLoadIsNamed) {
  const Arm arm = coulomb_arm(5e-3);
  const std::vector<data::Dataset> logs{make_log(arm, {})};
  const Prepared prepared = prepare(arm.robot, {}, logs, 2);
  FitReport report = fit(arm.robot, logs);
  ASSERT_TRUE(report.usable()) << text_of(report.faults);
  report.joints.clear();
  // Fc, mu_m, mu_b, nu_m, nu_b, Fv, v0, l0
  report.model.arm.friction =
      same_law("load_dependent", {4, 0.5, 0.5, 0.1, 0.1, 2, 0.01, 0.1}, arm.robot.n());
  const signals::Recording& r = prepared.recordings[0];
  report.residual_rms[1] = (predict_torque(report.model.arm, r, 10) - r.filtered_tau).col(1).norm();
  report.r2[1] = -report.residual_rms[1];
  report.faults = faults_of(prepared, report);
  EXPECT_THAT(text_of(report.faults), HasSubstr("grows with the load by more than the load"));
}

// What holds a joint that rests is anything within its friction: no law knows it.
TEST(Faults, TorqueAtRestWithinFrictionIsNoFaultUnlessTheMeanExplainsMore) {
  const Arm arm = coulomb_arm(5e-3);
  const std::vector<data::Dataset> logs{make_log(arm, {})};
  const Prepared prepared = prepare(arm.robot, {}, logs, 2);
  FitReport report = fit(arm.robot, logs);
  ASSERT_TRUE(report.usable()) << text_of(report.faults);
  EXPECT_GT(report.sliding_r2[1], 0.99);
  report.r2[1] = 0.1;
  report.resting_rms[1] = 1.9 * prepared.rigid_body.Fc[1];
  EXPECT_EQ(text_of(faults_of(prepared, report)), "");
  report.r2[1] = -0.1;
  EXPECT_THAT(text_of(faults_of(prepared, report)),
              testing::ContainsRegex("j2: R2 -0.1 on its own training torque, worse than its mean: "
                                     "while the joint slides it is explained \\(R2 [0-9.]+\\), "
                                     "where it rests [0-9.]+ N m of what holds it are not; leave"));
  report.resting_rms[1] = 2.1 * prepared.rigid_body.Fc[1];
  EXPECT_THAT(text_of(faults_of(prepared, report)), HasSubstr("j2: R2 -0.1 on its own training "
                                                              "torque; look for"));
}

// A joint that moves in a fifth of the time and is held by most of its static friction else.
TEST(Faults, AJointThatMostlyRestsIsNotTrustedWhereItsMeanExplainsMore) {
  const Arm arm = coulomb_arm(5e-3);
  data::Dataset log = make_log(arm, {.seconds = 24});
  for (int k = 0; k < log.length(); ++k) {
    const double s = std::sin(std::numbers::pi * std::clamp((log.t[k] - 8) / 4, 0.0, 1.0));
    log.q(k, 0) = 0.3 * std::pow(s, 4) * std::sin(2 * std::numbers::pi * log.t[k]);
  }
  const signals::Motion motion = signals::make_recording(log, 10).narrow;
  dynamics::Workspace<double> ws(arm.robot);
  const auto row = [](const auto& x, Eigen::Index k) {
    return std::span<const double>(x.row(k).data(), static_cast<std::size_t>(x.cols()));
  };
  Rng rng(1, 0);
  for (int k = 0; k < log.length(); ++k) {
    dynamics::rnea<double>(arm.robot, ws, row(arm.robot.pi.transpose(), 0), row(motion.q, k),
                           row(motion.v, k), row(motion.a, k), {log.tau.row(k).data(), 3});
    for (int j = 0; j < 3; ++j) {
      const bool rests = j == 0 && std::abs(log.t[k] - 10) > 2.1;
      log.tau(k, j) += (rests ? 7.2 : 8 * std::tanh(motion.v(k, j) / 5e-3)) + motion.v(k, j) +
                       0.02 * rng.normal();
    }
  }
  const FitReport report = fit(arm.robot, {log});
  EXPECT_LT(report.r2[0], 0);
  EXPECT_GT(report.sliding_r2[0], 0.9);
  EXPECT_THAT(text_of(report.faults), HasSubstr("j1: R2 -"));
  EXPECT_THAT(text_of(report.faults), HasSubstr("leave its rests out"));
}

TEST(Faults, TorqueThatNothingExplainsIsNotTrusted) {
  const Arm arm = coulomb_arm(5e-3);
  data::Dataset log = make_log(arm, {});
  Rng rng(1, 0);
  for (double& value : log.tau.col(1)) value = 20 * rng.normal();
  const FitReport report = fit(arm.robot, {log});
  EXPECT_FALSE(report.usable());
  EXPECT_THAT(text_of(report.faults), HasSubstr("j2: R2 "));
  EXPECT_THAT(report.brief(), HasSubstr("NOT TO BE TRUSTED"));
  const data::FitFile file = fit_file(report);
  EXPECT_FALSE(file.usable);
  ASSERT_FALSE(file.faults.empty());
  EXPECT_EQ(file.faults[0].joint, "j2");
}

TEST(Faults, FrictionAboveEveryTorqueIsNotTrusted) {
  const Arm arm = coulomb_arm(5e-3);
  const Prepared prepared = prepare(arm.robot, {}, std::vector{make_log(arm, {})}, 2);
  FitReport report = fit_conventional(prepared, model_of_one_start("dahl"), 1, 2);
  ASSERT_TRUE(report.usable()) << text_of(report.faults);
  report.model.arm.friction.theta[0] = 1e4;
  const std::vector<Fault> faults = faults_of(prepared, report);
  ASSERT_EQ(faults.size(), 1u);
  EXPECT_EQ(faults[0].joint, "j1");
  EXPECT_THAT(faults[0].found, HasSubstr("friction of 1e+04 N m, while its torque ranged over"));
}

TEST(Faults, CoulombFrictionOnABoundThatMattersIsNotTrusted) {
  Arm arm = coulomb_arm(5e-3);
  arm.robot.joints[1].effort = 0;  // unknown
  for (const bool upper : {true, false}) {
    Prepared prepared = prepare(arm.robot, {}, std::vector{make_log(arm, {})}, 2);
    FitReport report = fit_conventional(prepared, model_of_one_start("dahl"), 1, 2);
    friction::Friction& friction = report.model.arm.friction;
    const auto Fc = static_cast<std::size_t>(friction.model.parameter_begin(1));
    const friction::ParameterInfo& info = friction.model.parameters()[Fc].info;
    friction.theta[Fc] = upper ? info.upper * (1 - 1e-4) : info.lower * (1 + 1e-4);
    // torque beside which such friction is not too much, or not next to nothing
    const double largest = prepared.recordings[0].filtered_tau.col(1).cwiseAbs().maxCoeff();
    prepared.recordings[0].filtered_tau.col(1) *= (upper ? 10 : 30) * friction.theta[Fc] / largest;
    const std::vector<Fault> faults = faults_of(prepared, report);
    ASSERT_EQ(faults.size(), 1u) << text_of(faults);
    EXPECT_EQ(faults[0].joint, "j2");
    EXPECT_EQ(faults[0].found, fmt::format("Fc = {:.3g} N m ended on the {} bound of its law",
                                           friction.theta[Fc], upper ? "upper" : "lower"));
  }
}

// Of a Stribeck curve Fs may hold the friction of a joint that only ever moves slowly. At speeds
// that the motion has not, it may be anything.
TEST(Faults, CoulombFrictionOnItsLowerBoundIsNoFaultButItsStaticFrictionMayBe) {
  const Arm arm = coulomb_arm(5e-3);
  const Prepared prepared = prepare(arm.robot, {}, std::vector{make_log(arm, {})}, 2);
  FitReport report = fit_conventional(prepared, model_of_one_start("stribeck"), 1, 2);
  const auto& parameters = report.model.arm.friction.model.parameters();
  ASSERT_EQ(parameters[0].symbol, "Fc");
  ASSERT_EQ(parameters[1].symbol, "Fs");
  std::vector<double>& theta = report.model.arm.friction.theta;
  const auto of_j2 = static_cast<std::size_t>(report.model.arm.friction.model.parameter_begin(1));
  const double sliding = theta[of_j2];
  theta[of_j2] = std::nextafter(parameters[0].info.lower, 1);  // of a logarithm
  report.joints[1].theta[0] = theta[of_j2];
  report.joints[1].at_bound = {"Fc"};
  EXPECT_EQ(text_of(faults_of(prepared, report)), "");
  theta[of_j2 + 1] = 1e4;
  for (const double Fc : {theta[of_j2], sliding}) {
    theta[of_j2] = Fc;
    EXPECT_THAT(text_of(faults_of(prepared, report)),
                HasSubstr("j2: friction of 1e+04 N m, while its torque ranged over"));
  }
}

// Sums of laws are fitted all joints at once and have no fits of single joints.
TEST(Faults, SumsAreCheckedLikeConventionalLaws) {
  const Arm arm = coulomb_arm(5e-3);
  const Prepared prepared = prepare(arm.robot, {}, std::vector{make_log(arm, {})}, 2);
  FitReport report = fit_conventional(prepared, model_of_one_start("simple"), 1, 2);
  report.joints.clear();
  const friction::JointSpec joint{{{"stribeck", 0, {}}, {"maxwell_slip", 1, {}}}};
  friction::Friction& friction = report.model.arm.friction;
  friction.model = friction::RobotFriction(std::vector<friction::JointSpec>(3, joint));
  friction.theta.clear();
  // Fc Fs vs Fv v0, K W: a spring that never slips holds 2 N m/rad times the travel
  for (const double size : {1.0, 0.8, 0.5})
    for (const double value : {4 * size, 4.2 * size, 0.05, 2 * size, 0.01, 2 * size, 1e4})
      friction.theta.push_back(value);
  EXPECT_EQ(text_of(faults_of(prepared, report)), "");
  friction.theta[1] = 1e3;
  EXPECT_THAT(text_of(faults_of(prepared, report)), HasSubstr("j1: friction of 1.01e+03 N m"));
}

TEST(Faults, InertiaFarAboveTheRobotsFileIsNotTrusted) {
  const Arm arm = coulomb_arm(5e-3);
  const Prepared prepared = prepare(arm.robot, {}, std::vector{make_log(arm, {})}, 2);
  FitReport report = fit_conventional(prepared, model_of_one_start("simple"), 1, 2);
  ASSERT_TRUE(report.usable()) << text_of(report.faults);
  report.model.arm.robot.pi[report.model.arm.robot.armature_begin() + 2] = 5;
  const std::string text = text_of(faults_of(prepared, report));
  EXPECT_THAT(text, testing::ContainsRegex("j3: inertia of 5[.0-9]* kg m.2, [0-9]+ times that of "
                                           "the robot's file with its armature; record more"));
}

// Armatures without the square of the gear ratio, believed within 30 %.
TEST(Faults, APriorThatTheTorqueContradictsIsNotTrusted) {
  const Arm arm = coulomb_arm(5e-3);
  RigidBodyOptions options;
  options.prior.use = true;
  for (const double factor : {1.0, 1e-4}) {
    dynamics::RobotModel file = arm.robot;
    file.pi.segment(file.armature_begin(), file.n()) *= factor;
    const Prepared prepared = prepare(file, options, std::vector{make_log(arm, {})}, 2);
    const std::string text =
        text_of(fit_conventional(prepared, model_of_one_start("simple"), 1, 2).faults);
    EXPECT_EQ(text.find("[identify.prior] contradicts its torque") != std::string::npos,
              factor != 1)
        << factor << text;
  }
}

// A prior several of its standard deviations off, and data that know far better: under the spread
// of the whole torque the prior would win, and the residual that it leaves would go on saying so.
TEST(RigidBodyLeastSquares, DataThatKnowMoreThanThePriorMoveIt) {
  const Arm arm = coulomb_arm(5e-3);
  RigidBodyOptions options;
  options.prior.use = true;
  dynamics::RobotModel file = arm.robot;
  file.pi.segment(file.armature_begin(), file.n()) *= 0.1;
  const RigidBodyFit fit =
      prepare(file, options, std::vector{make_log(arm, {.torque_noise = 0.02})}, 2).rigid_body;
  for (int j = 0; j < arm.robot.n(); ++j) EXPECT_LT(fit.sigma[j], 4 * fit.sigma_alone[j]) << j;
}

// Without limits nothing says how large a rotor usually is: the guess is that of the links.
TEST(Faults, ARotorThatNoLimitTellsIsNoFault) {
  const Arm arm = coulomb_arm(5e-3);
  dynamics::RobotModel file = arm.robot;
  file.pi.segment(file.armature_begin(), file.n()).setZero();
  for (const bool limits : {true, false}) {
    if (!limits)
      for (dynamics::Joint& joint : file.joints) joint.velocity = joint.effort = 0;
    const Prepared prepared = prepare(file, {}, std::vector{make_log(arm, {})}, 2);
    FitReport report = fit_conventional(prepared, model_of_one_start("simple"), 1, 2);
    ASSERT_TRUE(report.usable()) << text_of(report.faults);
    report.model.arm.robot.pi[report.model.arm.robot.armature_begin() + 2] = 9;
    EXPECT_THAT(text_of(faults_of(prepared, report)),
                limits ? HasSubstr("with a usual armature; state its armature, "
                                   "robot.armature = {j3 = ...}; record more")
                       : HasSubstr(""));
    EXPECT_EQ(faults_of(prepared, report).empty(), !limits);
  }
}

// As of a wrong mount or a coupling that is not stated.
TEST(Faults, NegativeViscousFrictionIsNotTrusted) {
  const Arm arm = coulomb_arm(5e-3);
  data::Dataset log = make_log(arm, {.torque_noise = 0.2});
  log.tau.col(1) -= 4 * signals::make_recording(log, 10).narrow.v.col(1);
  EXPECT_THAT(text_of(fit(arm.robot, {log}).faults),
              testing::ContainsRegex("j2: viscous friction came out negative, -2[.0-9]* [+]- "));
}

// Friction falls with the speed where the joint is that slow.
TEST(Faults, NegativeViscousFrictionOfASlowJointNamesTheStribeckCurve) {
  const auto text =
      HasSubstr("speeds below 0.2 rad/s lie on the falling part of the Stribeck curve");
  const Arm arm = coulomb_arm(5e-4);
  for (const bool slow : {true, false}) {
    data::Dataset log = make_log(arm, {.peak_speed = slow ? 0.05 : 1.5, .torque_noise = 0.02});
    log.tau.col(1) -= 8 * signals::make_recording(log, 10).narrow.v.col(1);
    const std::string said = text_of(fit(arm.robot, {log}).faults);
    EXPECT_THAT(said, HasSubstr("j2: viscous friction came out negative"));
    EXPECT_EQ(testing::Matches(text)(said), slow) << said;
  }
}

TEST(Faults, ATorqueThatDoesNotVaryIsNamed) {
  const Arm arm = coulomb_arm(5e-3);
  data::Dataset log = make_log(arm, {.torque_noise = 0.2});
  log.tau.col(2).setConstant(1.5);
  const FitReport report = fit(arm.robot, {log});
  EXPECT_THAT(text_of(report.faults),
              HasSubstr("j3: its training torque does not vary; log the torque"));
  EXPECT_THAT(text_of(report.faults) + report.brief(), testing::Not(HasSubstr("nan")));
}

TEST(Faults, ASpeedThatTheMotionLacksIsLoweredInWords) {
  const Arm arm = coulomb_arm(5e-3);
  const std::vector<data::Dataset> logs{make_log(arm, {})};
  RigidBodyOptions options;
  EXPECT_EQ(prepare(arm.robot, options, logs, 2).rigid_body.slower, "");
  options.min_speed_rad_s = 50;
  EXPECT_THAT(prepare(arm.robot, options, logs, 2).rigid_body.slower,
              testing::MatchesRegex("min_speed_rad_s = 50 is too fast for the motion: rows enter "
                                    "from 0.[0-9]* rad/s of j1, .* rad/s of j3"));
}

// Too short for the base parameters: nominal values carry them, and the fit says so.
TEST(Faults, AShortLogTakesTheNominalValues) {
  const Arm arm = coulomb_arm(5e-3);
  LogOptions options;
  options.seconds = 2.4;
  options.torque_noise = 0.2;
  const data::Dataset log = make_log(arm, options);
  const Prepared prepared = prepare(arm.robot, {}, std::vector{log}, 2);
  EXPECT_EQ(prepared.rigid_body.outcome, Outcome::kConverged) << prepared.rigid_body.message;
  EXPECT_NE(prepared.rigid_body.prior, "");
  RigidBodyOptions alone;
  alone.prior_where_needed = false;
  const RigidBodyFit bare = rigid_body_least_squares(prepared.robot, prepared.recordings, alone);
  EXPECT_NE(bare.outcome, Outcome::kConverged);
  EXPECT_EQ(bare.prior, "");
}

// The joints reverse about once in the time that the filter remembers either way.
TEST(Faults, JointsThatReverseWithinTheMemoryOfTheFilterAreIdentified) {
  const Arm arm = coulomb_arm(5e-3);
  LogOptions options;
  options.torque_noise = 0.1;
  options.seconds = 24;
  RigidBodyOptions slow;
  slow.cutoff_hz = 3;
  const std::vector<data::Dataset> logs{make_log(arm, options)};
  const FitReport report =
      fit_conventional(prepare(arm.robot, slow, logs, 2), model_of_one_start("simple"), 1, 2);
  EXPECT_TRUE(report.usable()) << text_of(report.faults);
  for (int j = 0; j < arm.robot.n(); ++j) {
    const double scale = std::array{1.0, 0.8, 0.5}[static_cast<std::size_t>(j)];
    const JointFrictionFit& joint = report.joints[static_cast<std::size_t>(j)];
    EXPECT_NEAR(joint.theta[0], 4 * scale, 0.05 * 4 * scale) << j;
    EXPECT_NEAR(joint.theta[1], 2 * scale, 0.1 * 2 * scale) << j;
  }
}

// To and fro at one speed, as friction is often tested: what the speed varies by is the
// controller's answer to the torque.
TEST(Faults, OneSpeedTellsNoViscousFriction) {
  const Arm arm = coulomb_arm(5e-3);
  data::Dataset log = make_log(arm, {.torque_noise = 0.1});
  const int n = arm.robot.n(), half = 500;
  dynamics::Workspace<double> ws(arm.robot);
  const std::vector<double> zero(static_cast<std::size_t>(n), 0.0);
  for (int k = 0; k < log.length(); ++k) {
    const double phase = std::numbers::pi * k / half;
    for (int j = 0; j < n; ++j) log.q(k, j) = 0.4 * std::asin(0.998 * std::sin(phase + j)) / 1.5;
  }
  const signals::Recording motion = signals::make_recording(log, 10);
  for (int k = 0; k < log.length(); ++k) {
    std::vector<double> gravity(static_cast<std::size_t>(n));
    dynamics::rnea<double>(arm.robot, ws,
                           {arm.robot.pi.data(), static_cast<std::size_t>(arm.robot.pi.size())},
                           {log.q.row(k).data(), static_cast<std::size_t>(n)}, zero, zero, gravity);
    for (int j = 0; j < n; ++j) {
      const double v = motion.narrow.v(k, j), usual = v > 0 ? 0.21 : -0.21;
      log.tau(k, j) = gravity[static_cast<std::size_t>(j)] + (v > 0 ? 5 : -5) - 50 * (v - usual);
    }
  }
  const FitReport report = fit(arm.robot, {log});
  EXPECT_FALSE(report.usable());
  EXPECT_THAT(text_of(report.faults), HasSubstr("slides at one speed"));
  EXPECT_THAT(text_of(report.faults),
              testing::Not(HasSubstr("viscous friction came out negative")));
  const Identifiability found = examine_data(arm.robot, std::vector{motion}, {});
  for (const ParameterVerdict& p : found.parameters) {
    if (p.name.find("viscous") == std::string::npos) continue;
    EXPECT_EQ(p.verdict, Verdict::kNot) << p.name;
    EXPECT_THAT(p.words, HasSubstr("one speed"));
  }
}

}  // namespace
}  // namespace fricid::estimate
