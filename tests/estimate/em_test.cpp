// Expectation-maximisation on an arm whose truth is known.
#include "fricid/estimate/em/em.hpp"

#include <gtest/gtest.h>

#include <filesystem>
#include <thread>

#include "flywheel.hpp"
#include "fricid/base/error.hpp"
#include "fricid/base/rng.hpp"
#include "fricid/estimate/em/innovations.hpp"
#include "fricid/estimate/wash_out.hpp"
#include "kr6_truth.hpp"
#include "temporary_folder.hpp"
#include "unfiltered.hpp"

namespace fricid::estimate {
namespace {

constexpr double kEncoderNoise = 4e-6;  // [rad]
constexpr double kTorqueNoise = 0.02;   // [N m]

/// A noisy recording of the true arm.
signals::Recording noisy_record(const Arm& truth, std::uint64_t seed, int T) {
  const auto made = fricid::test::record(truth, fricid::test::HangingMotion(seed), T, {8, 1});
  signals::Recording out =
      fricid::test::unfiltered("recording", fricid::test::kSamplePeriod, made.q, made.v, made.tau);
  out.noise_sd.setConstant(kEncoderNoise);
  Rng rng(seed, 3);
  for (double& q : out.log.q.reshaped()) q += kEncoderNoise * rng.normal();
  for (double& tau : out.held_tau.reshaped()) tau += kTorqueNoise * rng.normal();
  return out;
}

class Em : public ::testing::Test {
 protected:
  Arm truth{fricid::test::hanging_kr6(), fricid::test::kr6_friction("dahl")};
  std::vector<signals::Recording> recordings;
  Arm start;
  EmOptions options;

  Em() {
    for (std::size_t p = 0; p < truth.friction.theta.size(); p += 3)
      truth.friction.theta[p + 1] = truth.friction.theta[p] / 2e-3;
    recordings = {noisy_record(truth, 1, 1200), noisy_record(truth, 2, 1200)};
    start = truth;
    Rng rng(8, 0);
    for (double& x : start.friction.theta) x *= rng.uniform() < 0.5 ? 0.7 : 1.3;
    options.rigid_body = false;
    options.iterations = 8;
    options.batch = 512;
    options.m_steps = 200;
    options.rate = 1e-2;
  }

  /// Error of the friction torque along the recordings, share of its rms, over all joints.
  double friction_error(const Arm& arm) const {
    double error = 0, size = 0;
    for (const signals::Recording& r : recordings) {
      const auto wanted =
          drive_friction(truth.friction, r.dt, r.wide.q, r.wide.v, r.held_tau, r.temperature).tau_f;
      const auto found =
          drive_friction(arm.friction, r.dt, r.wide.q, r.wide.v, r.held_tau, r.temperature).tau_f;
      error += (found - wanted).squaredNorm();
      size += wanted.squaredNorm();
    }
    return std::sqrt(error / size);
  }
};

TEST_F(Em, RecoversFrictionFromSmoothedPathsAlone) {
  options.m_step = MStep::kTransitions;
  for (const EStep method : {EStep::kEkf, EStep::kPsi}) {
    options.e_step = method;
    options.particles = 50;
    options.iterations = method == EStep::kEkf ? 14 : 8;
    const EmReport report = fit_em(start, recordings, options, "dahl", 2);
    ASSERT_EQ(report.outcome, Outcome::kIterationLimit) << report.message;
    EXPECT_GT(friction_error(start), 0.15);
    EXPECT_LT(friction_error(report.arm), 0.07) << name_of(method);
    EXPECT_GT(report.iterations.back().log_likelihood, report.iterations.front().log_likelihood);
  }
}

// Noise that moves q by dt/2 of what it moves v, as no stepper does, leaves an error of .47: the
// position equation holds the M-steps to the old acceleration.
TEST_F(Em, FindsFrictionByTransitionsWhereTheNoiseIsLarge) {
  truth.friction = fricid::test::kr6_friction("coulomb_viscous");
  recordings = {noisy_record(truth, 1, 1200), noisy_record(truth, 2, 1200)};
  start = truth;
  for (std::size_t p = 0; p < start.friction.theta.size(); ++p)
    if (is_torque(start.friction.model.parameters()[p].info.role)) start.friction.theta[p] *= 0.05;
  options.m_step = MStep::kTransitions;
  options.iterations = 3;
  options.keep = Keep::kLast;
  options.torque_noise = 1;
  options.torque_noise = 0.1 / std::sqrt(initial_noise(start, recordings, options).v.minCoeff());
  const EmReport report = fit_em(start, recordings, options, "simple", 2);
  ASSERT_EQ(report.outcome, Outcome::kIterationLimit) << report.message;
  EXPECT_GT(friction_error(start), 0.9);
  EXPECT_LT(friction_error(report.arm), 0.2);
}

// Backward sampling has more than its ancestors to choose from.
TEST_F(Em, AdaptedParticlesLookBackAtMoreThanThree) {
  const auto z = wash_out(truth, recordings, 1);
  const LatentNoise noise = initial_noise(truth, recordings, options);
  LatentFrictionModel model(truth, recordings[0], noise,
                            initial_state(recordings[0], z[0].row(0), latent_sizes(z), noise),
                            options.step);
  const EStepResult smoothed =
      smooth(model, recordings[0], 300, {EStep::kAdapted, options.particles, options.paths});
  ASSERT_FALSE(smoothed.failed);
  EXPECT_GT(smoothed.backward_ess, 3);
}

TEST_F(Em, RefusesARecordingShorterThanASecond) {
  recordings = {noisy_record(truth, 1, 249)};
  EXPECT_THROW(fit_em(start, recordings, options, "dahl", 2), UserError);
}

// What the transition density needs hundreds of iterations for.
TEST_F(Em, RecoversFrictionInFewIterationsByItsScore) {
  options.iterations = 6;
  const EmReport report = fit_em(start, recordings, options, "dahl", 2);
  ASSERT_EQ(report.outcome, Outcome::kIterationLimit) << report.message;
  EXPECT_GT(friction_error(start), 0.15);
  EXPECT_LT(friction_error(report.arm), 0.03);
}

// Without noise of the process and of the start the filter is the open loop, whose residuals' sum
// of squares can be differenced.
TEST_F(Em, ScoreOfAnOpenLoopIsTheSlopeOfItsLikelihood) {
  constexpr int kSteps = 40;
  const signals::Recording& r = recordings[0];
  const auto z = wash_out(start, recordings, 1);
  LatentNoise noise = initial_noise(start, recordings, options);
  noise.R.setConstant(1e-8);
  smc::Gaussian begin = initial_state(r, z[0].row(0), latent_sizes(z), noise);
  begin.covariance *= 1e-12;
  noise.q *= 1e-12;
  noise.v *= 1e-12;
  noise.z *= 1e-12;
  const smc::RowMatrix y = r.log.q.topRows(kSteps);
  const auto score = [&](const Arm& arm) {
    LatentFrictionModel model(arm, r, noise, begin, {8, 4});
    return innovation_score(model, y);
  };
  const InnovationScore here = score(start);
  LatentFrictionModel model(start, r, noise, begin, {8, 4});
  EXPECT_NEAR(here.log_likelihood, innovation_likelihood(model, y).sum(),
              1e-12 * std::abs(here.log_likelihood));
  ASSERT_FALSE(here.failed);

  const auto expect_slope = [&](double value, Eigen::Index column, auto change) {
    const double h = 1e-5 * value;
    Arm up = start, down = start;
    change(up, value + h);
    change(down, value - h);
    const double slope = (score(up).log_likelihood - score(down).log_likelihood) / (2 * h);
    EXPECT_NEAR(here.score[column] / slope, 1, 1e-3) << "parameter " << column;
  };
  for (const int p : {10, 21, 32}) {  // inertias that move something
    const double value = start.robot.pi[p];
    if (value != 0) expect_slope(value, p, [p](Arm& arm, double x) { arm.robot.pi[p] = x; });
  }
  for (std::size_t p = 0; p < start.friction.theta.size(); ++p)
    expect_slope(start.friction.theta[p], start.robot.pi.size() + static_cast<Eigen::Index>(p),
                 [p](Arm& arm, double x) { arm.friction.theta[p] = x; });
}

// Missing positions take nothing but their information.
TEST_F(Em, ScoreSkipsMissingPositions) {
  const auto z = wash_out(truth, recordings, 1);
  const LatentNoise noise = initial_noise(truth, recordings, options);
  const smc::Gaussian begin = initial_state(recordings[0], z[0].row(0), latent_sizes(z), noise);
  LatentFrictionModel model(truth, recordings[0], noise, begin, {8, 4});
  smc::RowMatrix y = recordings[0].log.q.topRows(100);
  const InnovationScore all = innovation_score(model, y);
  y.middleRows(50, 20).setConstant(std::nan(""));
  y(80, 3) = std::nan("");
  const InnovationScore some = innovation_score(model, y);
  ASSERT_FALSE(some.failed);
  EXPECT_NEAR(some.log_likelihood, innovation_likelihood(model, y).sum(),
              1e-12 * std::abs(some.log_likelihood));
  EXPECT_LT(some.information.trace(), all.information.trace());
  EXPECT_GT(some.information.trace(), 0);
}

/// One wheel whose friction is a stop of this length, viscous friction beside it, and the paper's
/// model of it, its latent at first over 2 mrad.
struct Stop {
  double length;
  Arm truth = fricid::test::flywheel(2, 0);
  std::vector<signals::Recording> recordings;
  Arm start;
  EmOptions options;

  explicit Stop(double true_length) : length(true_length) {
    friction::Friction& friction = truth.friction;
    friction.model =
        friction::RobotFriction({{{{"maxwell_slip", 1, {}}, {"viscous_power", 0, {}}}}});
    friction.theta = friction::default_theta(friction.model);
    const auto set = [&](std::string_view symbol, double value) {
      friction.theta[static_cast<std::size_t>(
          friction::find_parameter(friction.model, 0, "", symbol))] = value;
    };
    set("W1", kLevel);
    set("K1", kLevel / length);
    set("c", 6);
    set("p", 1);
    for (const std::uint64_t seed : {1, 2}) recordings.push_back(noisy_record(truth, seed, 2500));

    start = truth;
    start.friction.model =
        friction::RobotFriction(std::vector<friction::JointSpec>(1), {"lvm_paper", 32, 1});
    start.friction.theta = friction::default_theta(start.friction.model);
    friction::set_signal_sizes(start.friction.model, {{0}, {0.5}, {0.7}, {kLevel}},
                               start.friction.theta);
    friction::initialise_weights(start.friction.model, 1, start.friction.theta);
    options.m_step = MStep::kTransitions;
    options.iterations = 8;
    options.m_steps = 300;
    options.batch = 512;
    options.rate = 0.003;
    options.torque_noise = 1;
    options.z_noise_last = 0.03;
    options.ridge = 1e-3;
    options.rigid_body = false;
    options.keep = Keep::kLast;
  }

  Arm fitted(bool lengths) const {
    EmOptions with = options;
    with.lengths = lengths;
    const EmReport report = fit_em(start, recordings, with, "lvm_paper", 2);
    EXPECT_EQ(report.outcome, Outcome::kIterationLimit) << report.message;
    return report.arm;
  }

  /// |log| of the travel at .05 rad/s from rest until the latent is half way to where it stops,
  /// over that of the truth.
  double error(const Arm& arm) const {
    constexpr double kSpeed = 0.05, kStep = 1e-4;
    const std::vector<friction::Input<double>> in{{0, kSpeed, 0, 293}};
    std::vector<double> z(1), path;
    for (int k = 0; k < 20000; ++k) {
      arm.friction.model.step<double>(arm.friction.theta, in, kStep, z);
      path.push_back(std::abs(z[0]));
    }
    const auto half = std::ranges::find_if(path, [&](double x) { return x > path.back() / 2; });
    return std::abs(
        std::log(kSpeed * kStep * static_cast<double>(half - path.begin()) / (length / 2)));
  }

 private:
  static constexpr double kLevel = 10;  // [N m]
};

// The transition density knows less of the length than the likelihood.
TEST(EmLengths, AreRecoveredFromAThirdAndFromThreeTimes) {
  for (const double length : {2e-3 / 3, 6e-3}) {
    SCOPED_TRACE(length);
    const Stop stop(length);
    EXPECT_GT(stop.error(stop.start), std::log(2));
    EXPECT_LT(stop.error(stop.fitted(true)), std::log(1.2));
  }
  const Stop stop(6e-3);
  EXPECT_GT(stop.error(stop.fitted(false)), std::log(1.5));
}

TEST_F(Em, KeepsAStartThatCannotBeBettered) {
  options.iterations = 1;
  options.m_steps = 3;
  options.rate = 0.3;
  const EmReport report = fit_em(truth, recordings, options, "dahl", 2);
  EXPECT_EQ(report.best, -1);
  EXPECT_EQ(report.arm.friction.theta, truth.friction.theta);
}

/// How far a checkpoint has come.
struct Reached {
  int iteration = 0;
  template <class Archive>
  void visit(Archive& archive) {
    archive("iteration", iteration);
  }
};

// A fit begun from the state of another in its middle ends where that ends when it runs on.
TEST_F(Em, GoesOnFromItsCheckpoint) {
  const OwnFolder folder;
  const auto path = folder.path() / "fit" / "fit.json";
  const optimise::Checkpoint checkpoint(path, "key");

  // the state of a fit in its middle, as a kill would leave it
  options.iterations = 3;
  options.free_observation_noise = true;
  const EmReport straight = fit_em(start, recordings, options, "dahl", 2, checkpoint);
  EXPECT_FALSE(std::filesystem::exists(path));
  std::thread watcher([&] {
    while (!std::filesystem::exists(path)) std::this_thread::yield();
    std::filesystem::copy_file(path, path.parent_path() / "kept.json");
  });
  fit_em(start, recordings, options, "dahl", 2, checkpoint);
  watcher.join();
  std::filesystem::rename(path.parent_path() / "kept.json", path);
  Reached reached;
  ASSERT_TRUE(checkpoint.load(reached));
  ASSERT_GE(reached.iteration, 1);
  const EmReport resumed = fit_em(start, recordings, options, "dahl", 2, checkpoint);
  EXPECT_EQ(resumed.arm.friction.theta, straight.arm.friction.theta);
  EXPECT_EQ(resumed.noise.v, straight.noise.v);
  EXPECT_EQ(resumed.noise.R, straight.noise.R);
  EXPECT_EQ(resumed.message, straight.message);
  ASSERT_EQ(resumed.iterations.size(), straight.iterations.size());
  for (std::size_t i = 0; i < 3; ++i)
    EXPECT_EQ(resumed.iterations[i].held_out, straight.iterations[i].held_out);
}

TEST_F(Em, NoiseOfVelocityStaysAboveItsFloor) {
  options.iterations = 2;
  options.torque_floor = 1;
  const EmReport report = fit_em(start, recordings, options, "dahl", 2);
  options.torque_noise = options.torque_floor;
  const LatentNoise floor = initial_noise(start, recordings, options);
  for (Eigen::Index j = 0; j < floor.v.size(); ++j)
    EXPECT_NEAR(report.noise.v[j] / floor.v[j], 1, 1e-12);
}

// Encoders said to be three times as noisy as they are: freed, R falls towards them. It does not
// get there, since the noise of positions is twice what was said of the encoders and stays.
TEST_F(Em, FreedObservationNoiseIsThatOfTheEncoders) {
  for (signals::Recording& r : recordings) r.noise_sd *= 3;
  options.iterations = 10;
  options.free_observation_noise = true;
  const EmReport freed = fit_em(start, recordings, options, "dahl", 2);
  ASSERT_GE(freed.best, 8);
  for (const double variance : freed.noise.R)
    EXPECT_NEAR(std::sqrt(variance) / kEncoderNoise, 1.5, 0.6);
  options.iterations = 1;
  options.free_observation_noise = false;
  EXPECT_NEAR(fit_em(start, recordings, options, "dahl", 2).noise.R[0] / 144e-12, 1, 1e-9);
}

// Three ways to spoil a run, and the warning that names each; the unspoilt run has none of them.
TEST_F(Em, SaysWhatIsWrongWithItsNoiseAndItsParticles) {
  options.iterations = 1;
  options.e_step = EStep::kPsi;
  const auto warns = [&](const std::string& figure, const std::string& remedy) {
    const EmReport report = fit_em(truth, recordings, options, "dahl", 2);
    return std::ranges::any_of(report.warnings, [&](const std::string& text) {
      return text.find(figure) != std::string::npos && text.find(remedy) != std::string::npos;
    });
  };
  const auto set_noise = [&](double share) {
    options.torque_noise = options.torque_floor = 0.0025 * share;  // of friction of about 8 N m
    options.z_noise_first = options.z_noise_last = 0.01 * share;
  };
  set_noise(1);
  EXPECT_FALSE(warns("NIS", "raise Q"));
  EXPECT_FALSE(warns("particles", "more particles"));

  set_noise(1e-3);
  EXPECT_TRUE(warns("NIS", "raise Q"));
  set_noise(1);

  options.particles = 5;
  EXPECT_TRUE(warns("5 particles", "more particles"));
  options.particles = 200;

  for (signals::Recording& r : recordings) r.noise_sd *= 10;  // R 100 times too large
  EXPECT_TRUE(warns("NIS", "lower Q or R"));
}

TEST_F(Em, DoesNotDependOnTheNumberOfThreads) {
  options.iterations = 2;
  options.m_steps = 20;
  const EmReport one = fit_em(start, recordings, options, "dahl", 1);
  const EmReport three = fit_em(start, recordings, options, "dahl", 3);
  EXPECT_EQ(one.arm.friction.theta, three.arm.friction.theta);
  for (std::size_t i = 0; i < 2; ++i) {
    EXPECT_EQ(one.iterations[i].log_likelihood, three.iterations[i].log_likelihood);
    EXPECT_EQ(one.iterations[i].held_out, three.iterations[i].held_out);
  }
}

}  // namespace
}  // namespace fricid::estimate
