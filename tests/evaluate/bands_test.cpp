#include "fricid/evaluate/bands.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "contest.hpp"
#include "fricid/data/artefact.hpp"
#include "fricid/system/initial_state.hpp"

namespace fricid::test {
namespace {

using evaluate::Band;
using evaluate::draw_torque_error;
using evaluate::TorqueError;
using evaluate::Trajectory;

constexpr double kInertia = 0.3, kFv = 0.8, kTau = 0.5;

/// A wheel that spins up from rest under `kTau` and a torque error, which no log shows.
Trajectory disturbed_wheel(const Arm& arm, const TorqueError& error, int T, std::uint64_t stream) {
  const RowMatrix e = draw_torque_error(error, kSamplePeriod, T, 5, stream);
  Recording recording{RowMatrix(T, 1), RowMatrix(T, 1), RowMatrix::Constant(T, 1, kTau),
                      RowMatrix::Zero(T, 1), RowMatrix(T, 0)};
  ArmStepper<double> stepper(arm, {kSubsteps});
  std::vector<double> q{0}, v{0}, z, temperature{kRoomTemperature};
  for (Eigen::Index k = 0; k < T; ++k) {
    recording.q(k, 0) = q[0];
    recording.v(k, 0) = v[0];
    const std::vector<double> tau{kTau + evaluate::disturbance_at(v[0], e(k, 0), error.slow_gain)};
    stepper.step(tau, temperature, kSamplePeriod, q, v, z);
  }
  return as_trajectory(recording, "wheel");
}

std::vector<Trajectory> disturbed_wheels(const Arm& arm, const TorqueError& error, int count, int T,
                                         std::uint64_t first) {
  std::vector<Trajectory> wheels;
  for (int i = 0; i < count; ++i)
    wheels.push_back(disturbed_wheel(arm, error, T, first + static_cast<std::uint64_t>(i)));
  return wheels;
}

/// Standard deviation of q after every sample [rad], by the recursion of the covariance of
/// x = (q, v, e): within a sample v' = r v + (1 - r) e / Fv and q' = q + h v' four times over.
std::vector<double> closed_form_sd(const TorqueError& error, int T) {
  const double h = kSamplePeriod / kSubsteps, r = 1 - h * kFv / kInertia;
  Eigen::Matrix3d step = Eigen::Matrix3d::Identity();
  step.row(1) << 0, r, (1 - r) / kFv;
  step.row(0) << 1, h * r, h * (1 - r) / kFv;
  Eigen::Matrix3d A = step * step * step * step;
  const double rho = error.time > 0 ? std::exp(-kSamplePeriod / error.time) : 0;
  Eigen::Matrix3d P = Eigen::Matrix3d::Zero();
  P(2, 2) = error.sd[0] * error.sd[0];
  Eigen::Matrix3d hold = Eigen::Matrix3d::Identity(), Q = Eigen::Matrix3d::Zero();
  hold(2, 2) = rho;
  Q(2, 2) = (1 - rho * rho) * error.sd[0] * error.sd[0];
  std::vector<double> sd;
  for (int k = 0; k < T; ++k) {
    sd.push_back(std::sqrt(P(0, 0)));
    P = hold * A * P * A.transpose() * hold.transpose() + Q;
  }
  return sd;
}

evaluate::EvaluateOptions wheel_options(int draws) {
  evaluate::EvaluateOptions options;
  options.horizons_s = {0.1, 0.4, 0};
  options.starts = 2;
  options.substeps = kSubsteps;
  options.draws = draws;
  return options;
}

// Closed form: the stationary process has variance sd^2 at every sample and correlation
// exp(-lag/time); white from sample to sample at time 0.
TEST(TorqueErrorDraw, HasTheVarianceAndCorrelationOfItsName) {
  const int rows = 200, draws = 4000, lag = 10;
  for (const double time : {0.0, 0.05}) {
    double first = 0, last = 0, product = 0;
    for (std::uint64_t i = 0; i < draws; ++i) {
      const RowMatrix e = draw_torque_error({time, {1, 3}, 0}, kSamplePeriod, rows, 1, i);
      first += e(0, 1) * e(0, 1) / draws;
      last += e(rows - 1, 1) * e(rows - 1, 1) / draws;
      product += e(rows - 1 - lag, 1) * e(rows - 1, 1) / draws;
    }
    EXPECT_NEAR(first, 9, 0.6);
    EXPECT_NEAR(last, 9, 0.6);
    EXPECT_NEAR(product / 9, time > 0 ? std::exp(-lag * kSamplePeriod / time) : 0, 0.06);
  }
}

TEST(TorqueErrorDraw, IsFixedBySeedAndStream) {
  const TorqueError error{0.05, {1, 2}, 0};
  const RowMatrix once = draw_torque_error(error, kSamplePeriod, 50, 1, 2);
  EXPECT_EQ(once, draw_torque_error(error, kSamplePeriod, 50, 1, 2));
  EXPECT_EQ(once.topRows(20), draw_torque_error(error, kSamplePeriod, 20, 1, 2));
  EXPECT_NE(once, draw_torque_error(error, kSamplePeriod, 50, 1, 3));
  EXPECT_NE(once, draw_torque_error(error, kSamplePeriod, 50, 2, 2));
}

// Oracle: of N + 1 exchangeable draws each is as likely the last, so that the quantiles of N hold
// it with probability 0.9 for N = 19 and 39, whatever the distribution.
TEST(BandOf, HoldsAFurtherDrawNineTimesInTen) {
  Rng rng(3, 1);
  for (const int draws : {19, 39}) {
    const int T = 20000;
    std::vector<RowMatrix> q;
    for (int i = 0; i <= draws; ++i) {
      q.emplace_back(T, 1);
      for (Eigen::Index k = 0; k < T; ++k) q.back()(k, 0) = std::exp(2 * rng.normal());
    }
    Trajectory truth;
    truth.data.q = q.back();
    q.pop_back();
    EXPECT_NEAR(evaluate::score(evaluate::band_of(q), truth, T - 1).coverage, 0.9, 0.008) << draws;
  }
}

TEST(BandScoreOf, CountsWhatIsThereAndKnowsNoHorizonBeyond) {
  Band band{RowMatrix::Constant(4, 1, -1), RowMatrix::Constant(4, 1, 3)};
  Trajectory truth;
  truth.data.q = RowMatrix::Zero(4, 1);
  truth.data.q(1, 0) = 5;
  truth.data.q(2, 0) = std::numeric_limits<double>::quiet_NaN();
  EXPECT_DOUBLE_EQ(evaluate::score(band, truth, 3).coverage, 2.0 / 3);
  EXPECT_DOUBLE_EQ(evaluate::score(band, truth, 3).half_width, 2);
  EXPECT_TRUE(std::isnan(evaluate::score(band, truth, 4).coverage));
}

// What was measured may lie beyond a band by its noise; a truth has none.
TEST(BandScoreOf, LeavesRoomForTheNoiseOfWhatWasMeasured) {
  const Band narrow{RowMatrix::Zero(4000, 1), RowMatrix::Zero(4000, 1)};
  Trajectory measured;
  measured.data.q.resize(4000, 1);
  Rng rng(1, 2);
  for (double& q : measured.data.q.reshaped()) q = 1e-5 * rng.normal();
  EXPECT_EQ(evaluate::score(narrow, measured, 3999).coverage, 0);
  measured.q_sd = Eigen::VectorXd::Constant(1, 1e-5);
  EXPECT_NEAR(evaluate::score(narrow, measured, 3999).coverage, 0.9, 0.015);
  measured.truth = evaluate::Reference{measured.data.q, {}, {}, {}};
  EXPECT_EQ(evaluate::score(narrow, measured, 3999).coverage, 0);
}

// Closed form: the band of a linear wheel is 1.645 standard deviations of q wide to either side.
TEST(OpenLoopBands, AreAsWideAsTheClosedFormOfAWheel) {
  const data::ModelFile model = model_file("wheel", flywheel(kInertia, kFv));
  for (const double time : {0.0, 0.1}) {
    const TorqueError error{time, {0.05}, 0};
    const std::vector<Trajectory> undisturbed{disturbed_wheel(model.arm, {0, {0}, 0}, 250, 0)};
    const evaluate::Member member{&model, {error}};
    const Band band =
        evaluate::open_loop_bands({&member, 1}, undisturbed, wheel_options(1999), 2)[0];
    const std::vector<double> sd = closed_form_sd(error, 250);
    for (const int k : {10, 50, 249}) {
      const double half = (band.high(k, 0) - band.low(k, 0)) / 2;
      EXPECT_NEAR(half / (1.645 * sd[static_cast<std::size_t>(k)]), 1, 0.06) << time << ", " << k;
      const double middle = (band.high(k, 0) + band.low(k, 0)) / 2;
      EXPECT_NEAR(middle, undisturbed[0].data.q(k, 0), 0.1 * half);
    }
    EXPECT_EQ(band.low(0, 0), band.high(0, 0));
  }
}

// Simulated data with a known torque error: it is found again from open loops, and the band that
// follows covers 90 % of other data.
TEST(OpenLoopBands, CoverDataWithATorqueErrorFoundInOtherData) {
  const data::ModelFile model = model_file("wheel", flywheel(kInertia, kFv));
  for (const double time : {0.0, 0.1}) {
    const TorqueError truth{time, {0.02}, evaluate::kSlowGain};
    const auto training = disturbed_wheels(model.arm, truth, 60, 400, 100);
    const auto held_out = disturbed_wheels(model.arm, truth, 60, 400, 500);
    const evaluate::FittedTorqueError found =
        fit_torque_error(model, model.arm.robot, training, {}, wheel_options(39), 2);
    EXPECT_EQ(found.error.time, time);
    EXPECT_NEAR(found.error.sd[0] / 0.02, 1, 0.2);
    EXPECT_EQ(found.leap, kSubsteps);
    const evaluate::Member member{&model, found};
    const auto bands = evaluate::open_loop_bands({&member, 1}, held_out, wheel_options(39), 2);
    double coverage = 0;
    for (std::size_t i = 0; i < bands.size(); ++i)
      coverage += evaluate::score(bands[i], held_out[i], 399).coverage / 60;
    EXPECT_NEAR(coverage, 0.9, 0.05) << time;
  }
}

// A wheel held by Dahl friction, driven by a torque that trembles in the log and not in truth: the
// bristle slips by the trembling, in the rollout as in its draws, while the wheel stands.
TEST(OpenLoopBands, HoldAWheelThatOnlyTheNoiseOfItsTorqueMoves) {
  Arm arm = flywheel(kInertia, kFv);
  arm.friction =
      make_friction(1, {{{"dahl", 0, {}}}}, [](int, std::string_view, std::string_view symbol) {
        return symbol == "Fc" ? 1 : symbol == "sigma0" ? 1000 : 0.1;
      });
  const data::ModelFile model = model_file("wheel", arm);
  const double held = 0.5, noise = 0.1;
  const int T = 250, count = 20;
  std::vector<Trajectory> standing;
  for (std::uint64_t i = 0; i < count; ++i) {
    RowMatrix tau = draw_torque_error({0, {noise}, 0}, kSamplePeriod, T, 5, i);
    tau.topRows(5).setZero();  // the state of friction is known
    tau.array() += held;
    const RowMatrix zero = RowMatrix::Zero(T, 1);
    standing.push_back(as_trajectory({zero, zero, tau, zero, RowMatrix(T, 0)}, "wheel"));
  }
  const evaluate::Member member{&model, {{0, {noise}, 0}}};
  const std::vector<Band> bands =
      evaluate::open_loop_bands({&member, 1}, standing, wheel_options(39), 2);
  double coverage = 0, of_draws = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const Trajectory& one = standing[i];
    const std::vector<double> z0 = initial_friction_state(arm, kSamplePeriod, one.q, one.v,
                                                          one.data.tau, one.data.temperature);
    const std::vector<evaluate::OpenLoop> loop{{&arm, &one, {0, 0, T - 1}, z0}};
    const RowMatrix rollout = evaluate::roll_out(loop, {{kSubsteps}, 10})[0].q;
    coverage += evaluate::score(bands[i], one, T - 1).coverage / count;
    of_draws += evaluate::score(reflected(bands[i], rollout), one, T - 1).coverage / count;
  }
  EXPECT_GT(coverage, 0.6);
  EXPECT_LT(of_draws, 0.4);
}

// The draws of an arm widen its band.
TEST(OpenLoopBands, HoldTheArmsThatTheDataMightHaveGiven) {
  const data::ModelFile model = model_file("wheel", flywheel(kInertia, kFv));
  std::vector<Arm> draws;
  for (const double Fv : {0.9, 1.0, 1.1}) draws.push_back(flywheel(kInertia, Fv * kFv));
  const std::vector<Trajectory> still{disturbed_wheel(model.arm, {0, {0}, 0}, 250, 0)};
  const evaluate::Member member{&model, {{0, {0}, 0}}, draws};
  const Band band = evaluate::open_loop_bands({&member, 1}, still, wheel_options(39), 2)[0];
  const double fast = disturbed_wheel(draws[0], {0, {0}, 0}, 250, 0).data.q(249, 0),
               slow = disturbed_wheel(draws[2], {0, {0}, 0}, 250, 0).data.q(249, 0),
               middle = still[0].data.q(249, 0);
  EXPECT_NEAR(band.high(249, 0), 2 * middle - slow, 1e-9);
  EXPECT_NEAR(band.low(249, 0), 2 * middle - fast, 1e-9);
}

// Leaps make the band that steps make.
TEST(OpenLoopBands, ByLeapsAreThoseBySteps) {
  const evaluate::Contest contest = small_contest(400);
  const data::ModelFile& model = contest.models.back();
  evaluate::Member member{&model, {{0.03, {0.02, 0.02, 0.01, 0.005, 0.005, 0.005}, 3}}};
  const auto band_by = [&](int leap) {
    member.fitted.leap = leap;
    return evaluate::open_loop_bands({&member, 1}, contest.trajectories, wheel_options(39), 2)[0];
  };
  const Band steps = band_by(1), leaps = band_by(kSubsteps);
  const double width = (steps.high - steps.low).norm();
  EXPECT_GT(width, 0);
  EXPECT_NE(leaps.low, steps.low);
  EXPECT_LT((leaps.low - steps.low).norm(), 0.02 * width);
  EXPECT_LT((leaps.high - steps.high).norm(), 0.02 * width);
}

// Same bytes whatever the threads; other numbers for another recording, even of the same motion.
TEST(OpenLoopBands, DependOnNoThreadsAndDifferBetweenRecordings) {
  evaluate::Contest contest = small_contest(150);
  contest.trajectories[1] = contest.trajectories[0];
  const data::ModelFile& model = contest.models.back();
  const TorqueError error{0.03, {1, 1, 1, 0.5, 0.5, 0.5}, 3};
  const evaluate::Member member{&model, {error}};
  const auto bands = [&](int jobs) {
    return evaluate::open_loop_bands({&member, 1}, contest.trajectories, wheel_options(19), jobs);
  };
  const std::vector<Band> once = bands(1), again = bands(3);
  for (std::size_t i = 0; i < once.size(); ++i) {
    EXPECT_EQ(once[i].low, again[i].low);
    EXPECT_EQ(once[i].high, again[i].high);
    EXPECT_LT(once[i].low(149, 0), once[i].high(149, 0));
  }
  EXPECT_NE(once[0].low.row(149), once[1].low.row(149));
}

TEST(FitTorqueError, DependsOnNoThreads) {
  const evaluate::Contest contest = small_contest(150);
  const auto found = [&](int jobs) {
    return fit_torque_error(contest.models.back(), contest.robot, contest.trajectories, {},
                            wheel_options(19), jobs);
  };
  const evaluate::FittedTorqueError once = found(1), again = found(3);
  EXPECT_EQ(once.error.time, again.error.time);
  EXPECT_EQ(once.error.sd, again.error.sd);
  EXPECT_EQ(once.leap, again.leap);
}

// With training data the report has bands for fitted models, for one seed as for several.
TEST(Bands, StandInTheReport) {
  evaluate::Contest contest = small_contest(200);
  contest.training = contest.trajectories;
  data::ModelFile other = contest.models.back();
  other.seed = 2;
  contest.models.push_back(other);
  evaluate::EvaluateOptions options = small_options();
  options.draws = 19;
  const auto report = evaluate::evaluate(contest, options, 2);
  EXPECT_TRUE(report.summary.front().bands.empty());  // the oracle
  for (std::size_t i = 1; i < report.summary.size(); ++i) {
    const evaluate::Summary& summary = report.summary[i];
    ASSERT_EQ(summary.bands.size(), 2u);
    ASSERT_EQ(summary.band_coverage.size(), 3u);
    EXPECT_GT(summary.band_coverage[2], 0.3) << summary.name;
    EXPECT_TRUE(std::isnan(summary.band_coverage[1]));  // one second is longer than the recording
    EXPECT_GT(summary.band_half_width[2], summary.band_half_width[0]);
  }
  EXPECT_NE(to_markdown(report).find("90 % band"), std::string::npos);
  EXPECT_NE(data::to_json(report).find("band_coverage"), std::string::npos);
  options.draws = 0;
  EXPECT_TRUE(evaluate::evaluate(contest, options, 2).summary.back().bands.empty());
}

}  // namespace
}  // namespace fricid::test
