#include "fricid/signals/recording.hpp"

#include <cmath>
#include <limits>
#include <numbers>

#include <gmock/gmock.h>

#include "fricid/base/error.hpp"
#include "fricid/base/rng.hpp"

namespace fricid::signals {
namespace {

constexpr double kLogRate = 250, kLowPass = 10;
constexpr double kTurn = 2 * std::numbers::pi;

// A one-joint log of T samples from functions of time.
template <class Position, class Torque>
Dataset make_log(int T, Position position, Torque torque) {
  Dataset log;
  log.name = "log";
  log.joint_names = {"joint"};
  log.rate_hz = kLogRate;
  log.t = Eigen::VectorXd::LinSpaced(T, 0, (T - 1) / kLogRate);
  log.q.resize(T, 1);
  log.tau.resize(T, 1);
  for (int k = 0; k < T; ++k) {
    log.q(k, 0) = position(log.t[k]);
    log.tau(k, 0) = torque(log.t[k]);
  }
  return log;
}

// Reference: central differences of the filtered sine, exact in the middle of the log.
TEST(MakeRecording, DifferentiatesTheFilteredPosition) {
  const double f = 1.5, w = kTurn * f, dt = 1 / kLogRate;
  const auto log = make_log(
      2500, [&](double t) { return std::sin(w * t); }, [](double) { return 0.0; });
  const Recording out = make_recording(log, kLowPass);
  const double gain = ZeroPhaseButterworth(kLowPass, kLogRate).gain(f);
  for (int k = 1000; k < 1500; ++k) {
    const double t = log.t[k];
    ASSERT_NEAR(out.narrow.v(k, 0), gain * std::cos(w * t) * std::sin(w * dt) / dt, 1e-9);
    ASSERT_NEAR(out.narrow.a(k, 0), -gain * std::sin(w * t) * w * w, 1e-6);
  }
}

// Reference: a mass with friction that goes with its position, pushed by torques that are held over
// samples: the torque around a sample less that of friction at the sample is what accelerates it.
TEST(MakeRecording, TorqueAndAccelerationAreThoseOfTheSamples) {
  constexpr double kMass = 2, kStiffness = 3e3;  // resonates at 6 Hz
  const double dt = 1 / kLogRate, w = std::sqrt(kStiffness / kMass);
  Dataset log = make_log(
      3000, [](double) { return 0.0; }, [](double) { return 0.0; });
  double q = 0, v = 0;
  for (int k = 0; k < log.length(); ++k) {
    const double tau = 40 * std::sin(kTurn * 4 * log.t[k]) + 20 * std::sin(kTurn * 1.1 * log.t[k]);
    log.q(k, 0) = q;
    log.tau(k, 0) = tau;
    const double rest = tau / kStiffness, x = q - rest;
    q = rest + x * std::cos(w * dt) + v / w * std::sin(w * dt);
    v = v * std::cos(w * dt) - w * x * std::sin(w * dt);
  }
  const Recording out = make_recording(log, kLowPass);
  double left = 0, all = 0;
  for (int k = 500; k < 2500; ++k) {
    const double push = kMass * out.narrow.a(k, 0) + kStiffness * out.narrow.q(k, 0);
    left += std::pow(out.filtered_tau(k, 0) - push, 2);
    all += std::pow(out.filtered_tau(k, 0), 2);
  }
  EXPECT_LT(std::sqrt(left / all), 1e-4);
}

// Reference: the speed of the motion. A piece of a log begins and ends in motion; rollouts start
// from its first sample.
TEST(MakeRecording, KnowsTheSpeedAtBothEnds) {
  const double w = kTurn * 0.7;
  Rng rng(3, 0);
  const auto log = make_log(
      500, [&](double t) { return std::sin(w * t + 0.9) + 4e-6 * rng.normal(); },
      [](double) { return 0.0; });
  const Recording out = make_recording(log, kLowPass);
  for (const int k : {0, 499}) {
    const double v = w * std::cos(w * log.t[k] + 0.9), a = w * w;  // at most
    EXPECT_NEAR(out.wide.v(k, 0), v, 2e-4 * a) << k;
    EXPECT_NEAR(out.wide.q(k, 0), log.q(k, 0), 1e-5) << k;
  }
}

// Reference: a unit mass under held torque. q at the samples is exact, so the second difference of
// q must equal the torque in force around each sample: a log shifted by one sample fails here.
TEST(MakeRecording, AlignsHeldTorqueWithTheAccelerationOfAUnitMass) {
  const int T = 3000;
  const double dt = 1 / kLogRate;
  auto log = make_log(
      T, [](double) { return 0.0; },
      [](double t) { return std::sin(kTurn * 3 * t) + 0.5 * std::cos(kTurn * t); });
  double q = 0, v = 0.1;
  for (int k = 0; k < T; ++k) {
    log.q(k, 0) = q;
    const double a = log.tau(k, 0);
    q += dt * v + 0.5 * dt * dt * a;
    v += dt * a;
  }
  const Recording out = make_recording(log, kLowPass);
  for (int k = 1000; k < 2000; ++k) ASSERT_NEAR(out.narrow.a(k, 0), out.filtered_tau(k, 0), 1e-8);
}

TEST(MakeRecording, BridgesMissingSamplesAndLeavesThemOut) {
  auto log = make_log(
      2000, [](double t) { return t; }, [](double t) { return 2 * t; });
  for (int k = 900; k < 905; ++k) log.q(k, 0) = log.tau(k, 0) = std::nan("");
  const Recording out = make_recording(log, kLowPass);
  EXPECT_NEAR(out.narrow.q(902, 0), log.t[902], 1e-10);
  EXPECT_NEAR(out.filtered_tau(902, 0), 2 * (log.t[902] - 0.5 / kLogRate), 1e-9);
  EXPECT_FALSE(out.use(902, 0));
  EXPECT_FALSE(out.use(880, 0));
  EXPECT_TRUE(out.use(870, 0));
  EXPECT_FALSE(out.use(0, 0));
  EXPECT_FALSE(out.use(1999, 0));
}

// A joint that has not yet moved keeps a friction state that the log cannot know.
TEST(MakeRecording, LeavesOutAJointUntilItHasMoved) {
  const auto log = make_log(
      2000, [](double t) { return t < 4 ? 1.0 : 1.0 + 0.1 * (t - 4); }, [](double) { return 0.0; });
  const Recording out = make_recording(log, kLowPass);
  const int moved = static_cast<int>((4 + kWashout / 0.1) * kLogRate);
  EXPECT_FALSE(out.use(moved - 2, 0));
  EXPECT_TRUE(out.use(moved + 2, 0));
}

// Five times this cut-off lies beyond the Nyquist frequency: the wide band ends at 0.4 of the rate.
TEST(MakeRecording, FindsTheEncoderNoiseAtAHighCutoff) {
  constexpr double kNoise = 1e-5, kHighCutoff = 30;
  Rng rng(1, 0);
  const Dataset log = make_log(
      5000, [&](double t) { return 0.5 * std::sin(t) + kNoise * rng.normal(); },
      [](double) { return 0.0; });
  const Recording recording = make_recording(log, kHighCutoff);
  EXPECT_NEAR(recording.noise_sd[0], kNoise, 0.1 * kNoise);
}

// A joint that swings, stands still for three seconds and swings on, under 20 urad of encoder
// noise.
TEST(MakeRecording, AJointAtRestDoesNotTremble) {
  const double w = kTurn * 0.5, noise = 2e-5;
  const auto motion = [&](double t) {
    const double moving = t < 4 ? t : t < 7 ? 4.0 : t - 3;
    return 0.1 * (1 - std::cos(w * moving));
  };
  Rng rng(3, 0);
  const auto log = make_log(
      2750, [&](double t) { return motion(t) + noise * rng.normal(); }, [](double) { return 0.0; });
  const Recording out = make_recording(log, kLowPass);
  EXPECT_NEAR(out.noise_sd[0], noise, 0.1 * noise);
  double squares = 0;
  for (int k = 1100; k < 1650; ++k) squares += std::pow(out.wide.v(k, 0), 2) / 550;
  EXPECT_LT(std::sqrt(squares), 3e-5);  // .5 mrad/s where the noise passes
  for (int k = 0; k < log.length(); ++k)
    ASSERT_NEAR(out.wide.q(k, 0), motion(log.t[k]), 6 * noise) << k;
}

// Without noise, at the edge between two steps of its encoder.
TEST(MakeRecording, AStepToAndFroIsNoMotion) {
  constexpr double kStep = 1e-5;
  const auto log = make_log(
      3000,
      [&](double t) {
        const double q = t < 4 ? 0.1 * std::sin(kTurn * t / 4) : 1e-6 * std::sin(9 * t);
        return kStep * std::floor(q / kStep);
      },
      [](double) { return 0.0; });
  const Recording out = make_recording(log, kLowPass);
  EXPECT_NEAR(out.step[0], kStep, 1e-12);
  const UseMask rests = at_rest(out, kLowPass);
  for (int k = 1100; k < 2900; ++k) {
    ASSERT_NEAR(out.wide.v(k, 0), 0, 1e-5) << k;
    ASSERT_TRUE(rests(k, 0)) << k;
  }
  for (int k = 100; k < 900; ++k) ASSERT_FALSE(rests(k, 0)) << k;
}

// What moves slowly but further than the noise goes on moving.
TEST(MakeRecording, ASlowJointIsNotAtRest) {
  const double noise = 4e-6, speed = 1e-3;
  Rng rng(3, 0);
  const auto log = make_log(
      2000, [&](double t) { return speed * t + noise * rng.normal(); }, [](double) { return 0.0; });
  const Recording out = make_recording(log, kLowPass);
  for (int k = 100; k < 1900; ++k) ASSERT_NEAR(out.wide.q(k, 0), speed * log.t[k], 6 * noise) << k;
}

// Moves of a second with rests of .4 s between them, behind the tail of each move.
TEST(MakeRecording, ShortRestsAreFoundWhole) {
  const double noise = 2e-5, cycle = 1.4;
  Rng rng(4, 0);
  const auto move = [&](double t) {
    const double s = std::min(1.0, std::fmod(t, cycle));
    return std::floor(t / cycle) + s * s * s * (10 - 15 * s + 6 * s * s);
  };
  const auto log = make_log(
      7000, [&](double t) { return move(t) + noise * rng.normal(); }, [](double) { return 0.0; });
  const UseMask rests = at_rest(make_recording(log, kLowPass), kLowPass);
  for (int k = 300; k < 6700; ++k) {
    const double s = std::fmod(log.t[k], cycle);
    if ((s > 1.05 && s < 1.35) || (s > 0.2 && s < 0.8)) {
      ASSERT_EQ(rests(k, 0), s > 1) << k;
    }
  }
}

// Reference: the filtered sine between its samples.
TEST(BetweenSamples, FollowsTheMotion) {
  const double f = 12, w = kTurn * f;
  constexpr int kFactor = 4;
  auto log = make_log(
      2500, [&](double t) { return std::sin(w * t); }, [](double t) { return 3 * t; });
  const Recording recording = make_recording(log, kLowPass);
  const Eigen::VectorXd fine = between_samples(Eigen::VectorXd(recording.wide.q.col(0)), kFactor);
  ASSERT_EQ(fine.size(), (log.length() - 1) * kFactor + 1);
  const double gain = ZeroPhaseButterworth(wide_band(kLowPass, kLogRate), kLogRate).gain(f);
  for (int k = 4000; k < 6000; ++k) {
    ASSERT_NEAR(fine[k], gain * std::sin(w * k * recording.dt / kFactor), 1e-4) << k;
    if (k % kFactor == 0) {
      ASSERT_EQ(fine[k], recording.wide.q(k / kFactor, 0));
    }
  }
}

TEST(FilteredAgain, IsFilteredTwiceAndRestsAsBefore) {
  const double f = 45, w = kTurn * f, slow = 0.5;
  const auto moving = make_log(
      2500, [&](double t) { return slow * t + 0.01 * std::sin(w * t); },
      [](double) { return 0.0; });
  const Recording once = make_recording(moving, kLowPass);
  const Motion twice = filtered_again(once, kLowPass);
  const double gain = ZeroPhaseButterworth(wide_band(kLowPass, kLogRate), kLogRate).gain(f);
  ASSERT_LT(gain, 0.95);
  for (int k = 1000; k < 1500; ++k) {
    const double at = slow * moving.t[k];
    ASSERT_NEAR(twice.q(k, 0) - at, gain * (once.wide.q(k, 0) - at), 1e-6) << k;
    ASSERT_NEAR(twice.v(k, 0) - slow, gain * (once.wide.v(k, 0) - slow), 1e-4) << k;
  }
  Rng rng(3, 0);
  const auto resting = make_log(
      2500, [&](double t) { return (t < 5 ? std::sin(kTurn * t) : 0.0) + 2e-5 * rng.normal(); },
      [](double) { return 0.0; });
  const Recording rest = make_recording(resting, kLowPass);
  const Motion again = filtered_again(rest, kLowPass);
  for (int k = 1400; k < 2400; ++k) ASSERT_EQ(again.q(k, 0), rest.wide.q(k, 0)) << k;
}

TEST(MakeRecording, RefusesWhatItCannotFilter) {
  const auto zero = [](double) { return 0.0; };
  EXPECT_THROW(make_recording(make_log(100, zero, zero), kLowPass), UserError);
  auto empty = make_log(1000, zero, zero);
  empty.tau.setConstant(std::nan(""));
  EXPECT_THROW(make_recording(empty, kLowPass), UserError);
  auto giant = make_log(
      1000, [](double t) { return 1.7e308 * (t < 1 ? 1 : -1); }, zero);
  EXPECT_THROW(make_recording(giant, kLowPass), UserError);
}

// One log, two bands: the wide one is the narrow one of a filter kWideBand times as wide, and the
// log itself comes through untouched.
TEST(MakeRecording, HoldsTheLogAndBothBandsOfItsMotion) {
  const auto log = make_log(
      3000, [](double t) { return std::sin(kTurn * t) + 0.01 * std::sin(kTurn * 12 * t); },
      [](double t) { return std::cos(t); });
  const Recording out = make_recording(log, kLowPass);
  const Recording wider = make_recording(log, kWideBand * kLowPass);
  EXPECT_EQ(out.log.q, log.q);
  EXPECT_EQ(out.log.tau, log.tau);
  EXPECT_EQ(out.wide.q, wider.narrow.q);
  EXPECT_EQ(out.wide.v, wider.narrow.v);
  EXPECT_EQ(&out.motion(Band::kWide), &out.wide);
  EXPECT_EQ(&out.motion(Band::kNarrow), &out.narrow);
  EXPECT_GT((out.wide.q - out.narrow.q).norm(), 0.1 * 0.01 * std::sqrt(3000.));
}

TEST(HeldTorque, RepeatsTheLastValue) {
  const double gap = std::numeric_limits<double>::quiet_NaN();
  RowMatrix tau(4, 2), expected(4, 2);
  tau << gap, 1, 2, gap, gap, gap, 5, 6;
  expected << 0, 1, 2, 1, 2, 1, 5, 6;
  EXPECT_EQ(held_torque(tau), expected);
}

}  // namespace
}  // namespace fricid::signals
