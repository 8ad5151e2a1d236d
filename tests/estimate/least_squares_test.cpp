#include "fricid/estimate/rigid_body/least_squares.hpp"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <cmath>
#include <limits>

#include "arm_data.hpp"
#include "fricid/base/parallel.hpp"
#include "fricid/dynamics/base_parameters.hpp"
#include "fricid/dynamics/physical_inertia.hpp"
#include "fricid/signals/periods.hpp"
#include "recovery.hpp"

namespace fricid::estimate {
namespace {

constexpr double kCutoff = 10;

// Coulomb friction of 4 N m, viscous 2 N m s/rad, switching within 1 mrad/s.
std::vector<data::Dataset> clean_logs(const Arm& arm, LogOptions options, int count) {
  std::vector<data::Dataset> logs(static_cast<std::size_t>(count));
  parallel_for(count, 2, [&](int i) {
    LogOptions one = options;
    one.seed = 100 + static_cast<std::uint64_t>(i);
    logs[static_cast<std::size_t>(i)] = make_log(arm, one);
  });
  return logs;
}

std::vector<signals::Recording> filtered(std::span<const data::Dataset> logs) {
  std::vector<signals::Recording> out;
  for (const data::Dataset& log : logs) out.push_back(signals::make_recording(log, kCutoff));
  return out;
}

// A torque that a driver leaves out of every seventh message: no row is far enough from one.
TEST(RigidBodyLeastSquares, SaysWhereMissingValuesTakeAllRows) {
  const Arm arm = coulomb_arm();
  std::vector<data::Dataset> logs = clean_logs(arm, {}, 1);
  int lacking = 0;
  for (Eigen::Index k = 0; k < logs[0].tau.rows(); k += 7, ++lacking)
    logs[0].tau.row(k).setConstant(std::numeric_limits<double>::quiet_NaN());
  const RigidBodyFit fit = rigid_body_least_squares(arm.robot, filtered(logs), {});
  EXPECT_THAT(fit.message, testing::StartsWith("no sample of a joint that slides is left"));
  EXPECT_THAT(fit.message, testing::HasSubstr("log every channel at every sample"));
  EXPECT_THAT(fit.message,
              testing::HasSubstr(fmt::format("; {} of {} samples lack a position or a torque",
                                             lacking, logs[0].tau.rows())));
}

// A robot that differs from the truth by what a CAD file may be wrong.
dynamics::RobotModel wrong_cad(const dynamics::RobotModel& truth) {
  dynamics::RobotModel robot = truth;
  Rng rng(5, 0);
  for (int i = 0; i < robot.n(); ++i) {
    auto eta = dynamics::log_cholesky_from_inertia(robot.pi.segment<10>(10 * i));
    for (int k = 0; k < 10; ++k) eta[k] += 0.1 * rng.normal();
    robot.pi.segment<10>(10 * i) = dynamics::inertia_from_log_cholesky(eta);
    robot.pi[robot.armature_begin() + i] *= 1.3;
  }
  return robot;
}

// Reference: the injected truth, with clean data from an integrator of its own.
TEST(RigidBodyLeastSquares, FindsTruthWithoutNoise) {
  const Arm arm = coulomb_arm();
  LogOptions options;
  options.substeps = 200;
  const auto sequences = filtered(clean_logs(arm, options, 3));
  const RigidBodyFit fit = rigid_body_least_squares(wrong_cad(arm.robot), sequences, {});
  ASSERT_EQ(fit.outcome, Outcome::kConverged) << fit.message;
  expect_base_parameters(arm.robot, fit.base, sequences, 1e-3);
  expect_base_parameters(arm.robot, fit.base_physical, sequences, 1e-3);
  for (int j = 0; j < arm.robot.n(); ++j) {
    const double Fc = arm.friction.theta[static_cast<std::size_t>(3 * j)];
    const double Fv = arm.friction.theta[static_cast<std::size_t>(3 * j) + 1];
    EXPECT_NEAR(fit.Fc[j], Fc, 1e-3 * Fc);
    EXPECT_NEAR(fit.Fv[j], Fv, 1e-3 * Fv);
    EXPECT_NEAR(fit.offset[j], 0, 1e-3 * Fc);
  }
}

// Reference: the injected truth, whose last link carries 5 kg while the robot's file has next to
// nothing there: the physical parameters are those of the data, however far they are from the
// nominal ones.
TEST(RigidBodyLeastSquares, PhysicalParametersFollowTheDataFarFromTheFile) {
  constexpr double kMass = 5, kTurning = 0.02, kShare = 0.02;
  const Eigen::Vector3d centre(0.05, 0.02, 0.15);
  Arm arm = coulomb_arm();
  dynamics::RobotModel file = wrong_cad(arm.robot);
  file.pi.segment<10>(10 * (file.n() - 1)) *= kShare;
  const Eigen::Matrix3d I =
      kTurning * Eigen::Matrix3d::Identity() +
      kMass * (centre.squaredNorm() * Eigen::Matrix3d::Identity() - centre * centre.transpose());
  dynamics::Vector10 load;
  load << kMass, kMass * centre, I(0, 0), I(0, 1), I(1, 1), I(0, 2), I(1, 2), I(2, 2);
  arm.robot.pi.segment<10>(10 * (arm.robot.n() - 1)) += load;
  LogOptions options;
  options.substeps = 200;
  const auto sequences = filtered(clean_logs(arm, options, 3));
  const RigidBodyFit fit = rigid_body_least_squares(file, sequences, {});
  ASSERT_EQ(fit.outcome, Outcome::kConverged) << fit.message;
  expect_base_parameters(arm.robot, fit.base, sequences, 2e-3);
  expect_base_parameters(arm.robot, fit.base_physical, sequences, 2e-3);

  options.torque_noise = 0.3;
  const RigidBodyFit noisy =
      rigid_body_least_squares(file, filtered(clean_logs(arm, options, 3)), {});
  for (Eigen::Index i = 0; i < noisy.base.size(); ++i)
    EXPECT_NEAR(noisy.base_physical[i], noisy.base[i], 5 * noisy.base_se[i])
        << noisy.base_names[static_cast<std::size_t>(i)];
}

// Estimates, standard errors and truth of all parameters of one fit: base, Fc, Fv, offset.
struct Estimates {
  Eigen::VectorXd value, se, truth;
};

Estimates all_parameters(const RigidBodyFit& fit, const Arm& arm) {
  const int n = arm.robot.n();
  Eigen::VectorXd Fc(n), Fv(n);
  for (int j = 0; j < n; ++j) {
    Fc[j] = arm.friction.theta[static_cast<std::size_t>(3 * j)];
    Fv[j] = arm.friction.theta[static_cast<std::size_t>(3 * j) + 1];
  }
  const auto base = dynamics::base_parameters(arm.robot);
  Estimates out;
  const Eigen::Index size = fit.base.size() + 3 * n;
  out.value.resize(size), out.se.resize(size), out.truth.resize(size);
  out.value << fit.base, fit.Fc, fit.Fv, fit.offset;
  out.se << fit.base_se, fit.Fc_se, fit.Fv_se, fit.offset_se;
  out.truth << base.K * arm.robot.pi, Fc, Fv, Eigen::VectorXd::Zero(n);
  return out;
}

// How often intervals hold the truth, over draws of noise.
struct Coverage {
  std::vector<int> inside;       ///< of each parameter, 90 % intervals
  double ninety = 0, three = 0;  ///< share within 1.645 and 3 standard errors, all parameters
};

// @param disturb  adds noise to a log, of a seed
template <class Disturb>
Coverage coverage(int seeds, const Disturb& disturb, const LogOptions& options = {}) {
  constexpr double kNinety = 1.645;
  const Arm arm = coulomb_arm();
  const auto logs = clean_logs(arm, options, 2);
  std::vector<Estimates> runs(static_cast<std::size_t>(seeds));
  parallel_for(seeds, 2, [&](int seed) {
    auto noisy = logs;
    Rng rng(static_cast<std::uint64_t>(seed), 7);
    for (data::Dataset& log : noisy) disturb(arm.robot, rng, log);
    runs[static_cast<std::size_t>(seed)] =
        all_parameters(rigid_body_least_squares(arm.robot, filtered(noisy), {}), arm);
  });
  Coverage out;
  for (Eigen::Index i = 0; i < runs[0].value.size(); ++i) {
    int& inside = out.inside.emplace_back(0);
    for (const Estimates& run : runs) {
      const double z = std::abs(run.value[i] - run.truth[i]) / run.se[i];
      inside += z < kNinety;
      out.three += z < 3;
    }
    out.ninety += inside;
  }
  const auto all = static_cast<double>(seeds * std::ssize(out.inside));
  out.ninety /= all, out.three /= all;
  return out;
}

// Reference: the sampling distribution. 50 draws of the sensor noise of a KR 6 (torque 0.5 % of the
// effort limit, encoder 4e-6 rad): every estimate is within 3 standard errors as often as a normal
// distribution promises (0.27 %, 1 % allowed), and 90 % intervals cover 80 to 97 %.
TEST(RigidBodyLeastSquares, StandardErrorsAreHonest) {
  const Coverage found = coverage(50, [](const auto& robot, Rng& rng, data::Dataset& log) {
    for (Eigen::Index k = 0; k < log.tau.rows(); ++k)
      for (Eigen::Index j = 0; j < log.tau.cols(); ++j) {
        log.tau(k, j) += 0.005 * robot.joints[static_cast<std::size_t>(j)].effort * rng.normal();
        log.q(k, j) += 4e-6 * rng.normal();
      }
  });
  // 32 of 50 happens to one honest interval in a million.
  for (std::size_t i = 0; i < found.inside.size(); ++i)
    EXPECT_GT(found.inside[i], 32) << "parameter " << i;
  EXPECT_GE(found.ninety, 0.80);
  EXPECT_LE(found.ninety, 0.97);
  EXPECT_GE(found.three, 0.99);
  RecordProperty("covered", std::to_string(found.ninety));
}

// Reference: the sampling distribution, where the torque has a disturbance that lasts: constant for
// 0.4 s, as what a rigid model leaves of friction's memory.
TEST(RigidBodyLeastSquares, StandardErrorsHoldWhereResidualsAreCorrelated) {
  const Coverage found = coverage(50, [](const auto& robot, Rng& rng, data::Dataset& log) {
    constexpr double kLasts = 0.4;  // [s]
    const auto lasts = static_cast<Eigen::Index>(kLasts * log.rate_hz);
    for (Eigen::Index j = 0; j < log.tau.cols(); ++j) {
      double now = 0;
      for (Eigen::Index k = 0; k < log.tau.rows(); ++k) {
        if (k % lasts == 0)
          now = 0.01 * robot.joints[static_cast<std::size_t>(j)].effort * rng.normal();
        log.tau(k, j) += now;
      }
    }
  });
  EXPECT_GE(found.ninety, 0.80);
  EXPECT_LE(found.ninety, 0.97);
  EXPECT_GE(found.three, 0.97);
  RecordProperty("covered", std::to_string(found.ninety));
}

// A motion that is recorded twice, with the same disturbance in it, says no more than once.
TEST(RigidBodyLeastSquares, StandardErrorsCountPassagesOfAMotionAsOne) {
  const Arm arm = coulomb_arm();
  data::Dataset log = clean_logs(arm, {}, 1)[0];
  Rng rng(1, 7);
  for (Eigen::Index j = 0; j < log.tau.cols(); ++j)
    for (Eigen::Index k = 0; k < log.tau.rows(); ++k)
      log.tau(k, j) += 0.3 * std::sin(0.1 * static_cast<double>(k + 40 * j)) + 0.1 * rng.normal();
  const auto errors_of = [&](const std::vector<data::Dataset>& logs) {
    std::vector<signals::Recording> recordings = filtered(logs);
    signals::mark_repeats(recordings, 1);
    return rigid_body_least_squares(arm.robot, recordings, {}).base_se;
  };
  const Eigen::VectorXd once = errors_of({log}), twice = errors_of({log, log});
  for (Eigen::Index i = 0; i < once.size(); ++i)
    EXPECT_NEAR(twice[i] / once[i], 1, 0.05) << "base parameter " << i;
}

// Reference: the sampling distribution, where encoder noise makes accelerations of about half those
// of a slow motion: parameters that are multiplied with it are pulled to zero, and their errors
// tell.
TEST(RigidBodyLeastSquares, StandardErrorsHoldWhereTheMotionIsHardlyAboveTheNoise) {
  const Coverage found = coverage(30,
                                  [](const auto&, Rng& rng, data::Dataset& log) {
                                    for (Eigen::Index k = 0; k < log.tau.rows(); ++k)
                                      for (Eigen::Index j = 0; j < log.tau.cols(); ++j) {
                                        log.tau(k, j) += 0.01 * rng.normal();
                                        log.q(k, j) += 1e-3 * rng.normal();
                                      }
                                  },
                                  {.seconds = 36, .peak_speed = 0.5, .repeats = false});
  EXPECT_GE(found.ninety, 0.85);
  EXPECT_GE(found.three, 0.98);
  RecordProperty("covered", std::to_string(found.ninety));
}

// Logs of which no one knows whether their torque is held from its samples or, as in every second
// one, was measured at them.
TEST(RigidBodyLeastSquares, StandardErrorsHoldWhereTheTimingOfTheTorqueIsUnknown) {
  const auto disturbed = [](double unknown) {
    return coverage(20,
                    [unknown](const auto&, Rng& rng, data::Dataset& log) {
                      const bool measured = rng.uniform() < 0.5;
                      for (Eigen::Index k = log.tau.rows() - 1; k > 0; --k) {
                        if (measured) log.tau.row(k) = (log.tau.row(k - 1) + log.tau.row(k)) / 2;
                        for (Eigen::Index j = 0; j < log.tau.cols(); ++j)
                          log.tau(k, j) += 0.01 * rng.normal();
                      }
                      log.torque_delay_sd = unknown * log.dt();
                    },
                    {.seconds = 24, .repeats = false});
  };
  const Coverage known = disturbed(0.35), taken_as_held = disturbed(0);
  EXPECT_GE(known.ninety, 0.85);
  EXPECT_GE(known.three, 0.98);
  EXPECT_LT(taken_as_held.ninety, 0.75);
}

// Friction that lags behind the speed by a time T is T Fv a less: a negative inertia. The armature
// of that joint is held, those of the others are found as without it.
TEST(RigidBodyLeastSquares, AJointThatShowsNoInertiaKeepsItsNominalArmature) {
  const Arm arm = coulomb_arm();
  std::vector<data::Dataset> logs = clean_logs(arm, {}, 2);
  const dynamics::RobotModel cad = wrong_cad(arm.robot);
  const auto clean = filtered(logs);
  const RigidBodyFit before = rigid_body_least_squares(cad, clean, {});
  EXPECT_TRUE(before.without_inertia.empty());

  const Eigen::Index last = arm.robot.n() - 1;
  const double armature = cad.pi[cad.armature_begin() + last];
  for (std::size_t s = 0; s < logs.size(); ++s)
    logs[s].tau.col(last) -= 3 * armature * clean[s].narrow.a.col(last);
  const auto lagging = filtered(logs);
  const RigidBodyFit fit = rigid_body_least_squares(cad, lagging, {});
  ASSERT_EQ(fit.without_inertia.size(), 1u);
  EXPECT_EQ(fit.without_inertia[0].joint, last);
  EXPECT_LT(fit.without_inertia[0].value, 0);
  EXPECT_GT(fit.without_inertia[0].error, 0);
  EXPECT_EQ(fit.prior, "");
  EXPECT_NEAR(fit.pi[cad.armature_begin() + last], armature, 0.01 * armature);
  // nobody measured it: its errors are those of a nominal value
  const auto base = dynamics::base_parameters(cad);
  for (Eigen::Index i = 0; i < fit.base.size(); ++i) {
    if (base.K(i, cad.armature_begin() + last) == 0) continue;
    EXPECT_GT(fit.base_se[i], 0.29 * armature) << fit.base_names[static_cast<std::size_t>(i)];
  }
  for (Eigen::Index j = 0; j < last; ++j)
    EXPECT_NEAR(fit.Fc[j], before.Fc[j], 0.01 * before.Fc[j]) << j;

  // Left alone it would have lost its inertia; further fits keep it.
  RigidBodyOptions alone;
  alone.prior_where_needed = false;
  const RigidBodyFit lost = rigid_body_least_squares(cad, lagging, alone);
  EXPECT_LT(lost.pi[cad.armature_begin() + last], 0.01 * armature);
  const RigidBodyFit again = rigid_body_least_squares(cad, lagging, as_needed({}, fit));
  EXPECT_NEAR(again.pi[cad.armature_begin() + last], armature, 0.01 * armature);
}

// Of a joint that slides in one direction the sum of Coulomb friction and offset is known: the
// prior gives it to friction.
TEST(RigidBodyLeastSquares, SlidingInOneDirectionIsFrictionNotOffset) {
  const Arm arm = coulomb_arm();
  LogOptions noisy;
  noisy.torque_noise = 0.3;
  auto sequences = filtered(clean_logs(arm, noisy, 2));
  for (signals::Recording& r : sequences) r.use = r.use && (r.narrow.v.array() > 0);
  RigidBodyOptions alone;
  alone.prior_where_needed = false;
  EXPECT_NE(rigid_body_least_squares(arm.robot, sequences, alone).outcome, Outcome::kConverged);
  const RigidBodyFit fit = rigid_body_least_squares(arm.robot, sequences, {});
  EXPECT_NE(fit.prior, "");
  for (int j = 0; j < arm.robot.n(); ++j) {
    const double Fc = arm.friction.theta[static_cast<std::size_t>(3 * j)];
    EXPECT_NEAR(fit.Fc[j], Fc, 0.25 * Fc) << j;
    EXPECT_LT(std::abs(fit.offset[j]), 0.25 * Fc) << j;
  }
}

PriorOptions prior_of_width(double width) {
  PriorOptions prior;
  prior.use = true;
  prior.mass = prior.inertia = prior.armature = width;
  prior.com_m = width;
  return prior;
}

// Limit: a prior without width is the answer.
TEST(RigidBodyLeastSquares, InfinitelyTightPriorGivesTheCadValues) {
  const Arm arm = coulomb_arm();
  const auto sequences = filtered(clean_logs(arm, {}, 1));
  const dynamics::RobotModel cad = wrong_cad(arm.robot);
  RigidBodyOptions options;
  options.prior = prior_of_width(1e-7);
  const RigidBodyFit fit = rigid_body_least_squares(cad, sequences, options);
  const auto base = dynamics::base_parameters(cad);
  EXPECT_LT((fit.pi - cad.pi).norm(), 1e-5 * cad.pi.norm());
  EXPECT_LT((fit.base - base.K * cad.pi).norm(), 1e-5 * fit.base.norm());
}

// Limit: a prior of endless width leaves the least-squares solution.
TEST(RigidBodyLeastSquares, InfinitelyWeakPriorGivesLeastSquares) {
  const Arm arm = coulomb_arm();
  LogOptions log;
  log.torque_noise = 0.3;
  const auto sequences = filtered(clean_logs(arm, log, 1));
  const dynamics::RobotModel cad = wrong_cad(arm.robot);
  RigidBodyOptions options;
  const RigidBodyFit free = rigid_body_least_squares(cad, sequences, options);
  options.prior = prior_of_width(100);
  const RigidBodyFit weak = rigid_body_least_squares(cad, sequences, options);
  for (Eigen::Index i = 0; i < free.base.size(); ++i) {
    SCOPED_TRACE(free.base_names[static_cast<std::size_t>(i)]);
    EXPECT_NEAR(weak.base[i], free.base[i], 0.01 * free.base_se[i]);
    EXPECT_NEAR(weak.base_se[i], free.base_se[i], 0.02 * free.base_se[i]);
  }
}

}  // namespace
}  // namespace fricid::estimate
