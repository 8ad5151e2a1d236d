#include "fricid/evaluate/rollout.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "contest.hpp"
#include "fricid/base/error.hpp"

namespace fricid::test {
namespace {

using evaluate::OpenLoop;
using evaluate::Rollout;
using evaluate::RolloutOptions;
using evaluate::Start;
using evaluate::Trajectory;

std::vector<double> row(const RowMatrix& matrix, Eigen::Index k) {
  return {matrix.row(k).begin(), matrix.row(k).end()};
}

/// One arm from several starts.
std::vector<Rollout> roll_out(const Arm& arm, std::span<const Trajectory> trajectories,
                              std::span<const Start> starts,
                              std::span<const std::vector<double>> z0,
                              const RolloutOptions& options,
                              std::span<const RowMatrix> disturbance = {}) {
  std::vector<OpenLoop> loops;
  for (std::size_t i = 0; i < starts.size(); ++i)
    loops.push_back({&arm, &trajectories[static_cast<std::size_t>(starts[i].trajectory)], starts[i],
                     z0[i], disturbance.empty() ? nullptr : &disturbance[i]});
  return evaluate::roll_out(loops, options);
}

/// A wheel under constant torque: T samples of its own recording.
Trajectory spinning(const Arm& arm, double tau, int T) {
  Recording recording{RowMatrix(T, 1), RowMatrix(T, 1), RowMatrix::Constant(T, 1, tau),
                      RowMatrix::Zero(T, 1), RowMatrix(T, 0)};
  ArmStepper<double> stepper(arm, {kSubsteps});
  std::vector<double> q{0.1}, v{0.2}, z, torque{tau}, temperature{kRoomTemperature};
  for (Eigen::Index k = 0; k < T; ++k) {
    recording.q(k, 0) = q[0];
    recording.v(k, 0) = v[0];
    stepper.step(torque, temperature, kSamplePeriod, q, v, z);
  }
  return as_trajectory(recording, "wheel");
}

TEST(RollOut, FollowsTheClosedFormOfAWheel) {
  const double inertia = 0.3, Fv = 0.8, tau = 0.5, v0 = 0.2;
  const Arm arm = flywheel(inertia, Fv);
  std::vector<Trajectory> trajectories{spinning(arm, tau, 300)};
  const std::vector<Start> starts{{0, 0, 299}};
  const auto rollout = roll_out(arm, trajectories, starts, {{{}}}, {{kSubsteps}, 10})[0];

  const double h = kSamplePeriod / kSubsteps, r = 1 - h * Fv / inertia, end = tau / Fv;
  for (int k : {0, 1, 77, 299}) {
    const double v = end + std::pow(r, k * kSubsteps) * (v0 - end);
    EXPECT_NEAR(rollout.v(k, 0), v, 1e-13) << "sample " << k;
    EXPECT_NEAR(rollout.tau_f(k, 0), Fv * v, 1e-13) << "sample " << k;
  }
}

TEST(RollOut, TheTrueModelRepeatsItsOwnRecordingFromAnyStart) {
  const Arm arm{hanging_kr6(), kr6_friction("gms")};
  const std::vector<Trajectory> trajectories{
      as_trajectory(record(arm, HangingMotion(1), 300, {kSubsteps}), "a"),
      as_trajectory(record(arm, HangingMotion(2), 200, {kSubsteps}), "b")};
  const std::vector<Start> starts{{0, 0, 299}, {1, 0, 199}, {0, 150, 100}, {1, 30, 20}};
  std::vector<std::vector<double>> z0;
  for (const Start& start : starts)
    z0.push_back(
        row(trajectories[static_cast<std::size_t>(start.trajectory)].truth->z, start.begin));
  const auto rollouts = roll_out(arm, trajectories, starts, z0, {{kSubsteps}, 10});
  for (std::size_t i = 0; i < starts.size(); ++i) {
    const auto& truth = *trajectories[static_cast<std::size_t>(starts[i].trajectory)].truth;
    ASSERT_EQ(rollouts[i].q.rows(), starts[i].steps + 1);
    EXPECT_EQ(rollouts[i].q, truth.q.middleRows(starts[i].begin, starts[i].steps + 1));
    EXPECT_EQ(rollouts[i].v, truth.v.middleRows(starts[i].begin, starts[i].steps + 1));
    EXPECT_EQ(rollouts[i].tau_f, truth.tau_f.middleRows(starts[i].begin, starts[i].steps + 1));
    EXPECT_FALSE(rollouts[i].diverged);
  }
}

// A disturbance moves the arm as the torque does, and is no part of the friction; a lane is the
// same whatever the others do.
TEST(RollOut, ADisturbanceAddsToTheTorqueAndIsTakenFromTheFriction) {
  const Arm arm = flywheel(0.3, 0.8);
  std::vector<Trajectory> half{spinning(arm, 0.5, 50)}, whole = half;
  whole[0].data.tau.setConstant(0.6);
  const std::vector<Start> starts{{0, 0, 49}, {0, 0, 49}};
  const std::vector<RowMatrix> disturbance{RowMatrix::Zero(50, 1), RowMatrix::Constant(50, 1, 0.1)};
  const RolloutOptions options{{kSubsteps}, 10};
  const auto made = roll_out(arm, half, starts, {{{}, {}}}, options, disturbance);
  const auto wanted = roll_out(arm, whole, {&starts[0], 1}, {{{}}}, options)[0];
  EXPECT_EQ(made[0].q, roll_out(arm, half, {&starts[0], 1}, {{{}}}, options)[0].q);
  EXPECT_EQ(made[1].q, wanted.q);
  EXPECT_TRUE(made[1].tau_f.isApprox((wanted.tau_f.array() - 0.1).matrix(), 1e-12));

  // four times as much at rest, 2.5 times at 0.1 rad/s
  const auto slow = roll_out(arm, half, starts, {{{}, {}}}, {{kSubsteps}, 10, 3}, disturbance)[1];
  for (Eigen::Index k = 0; k < 50; ++k)
    EXPECT_NEAR(0.8 * slow.v(k, 0) - slow.tau_f(k, 0),
                0.1 * (1 + 3 / (1 + std::pow(slow.v(k, 0) / 0.1, 2))), 1e-12);
  EXPECT_GT(slow.q(49, 0), made[1].q(49, 0));
}

// Arms that differ in parameters share lanes, and each moves as it does alone.
TEST(RollOut, LanesHaveArmsOfTheirOwn) {
  const Arm truth{hanging_kr6(), kr6_friction("gms")};
  std::vector<Arm> arms(3, truth);
  for (double& parameter : arms[1].friction.theta) parameter *= 1.01;
  arms[2].robot.pi *= 1.01;
  const Trajectory trajectory =
      as_trajectory(record(truth, HangingMotion(1), 100, {kSubsteps}), "a");
  const std::vector<double> z0 = row(trajectory.truth->z, 0);
  std::vector<OpenLoop> loops;
  for (const Arm& arm : arms) loops.push_back({&arm, &trajectory, {0, 0, 99}, z0});
  const std::vector<Rollout> together = evaluate::roll_out(loops, {{kSubsteps}, 10});
  for (std::size_t i = 0; i < loops.size(); ++i) {
    const Rollout alone = evaluate::roll_out({&loops[i], 1}, {{kSubsteps}, 10})[0];
    EXPECT_EQ(together[i].q, alone.q);
    EXPECT_EQ(together[i].tau_f, alone.tau_f);
    EXPECT_EQ(together[i].q == together[0].q, i == 0);
  }
}

TEST(RollOut, MissingTorqueRepeatsTheLast) {
  const Arm arm = flywheel(0.3, 0.8);
  std::vector<Trajectory> whole{spinning(arm, 0.5, 50)}, gaps = whole;
  gaps[0].data.tau.middleRows(10, 20).setConstant(std::numeric_limits<double>::quiet_NaN());
  const std::vector<Start> starts{{0, 0, 49}};
  EXPECT_EQ(roll_out(arm, whole, starts, {{{}}}, {{kSubsteps}, 10})[0].q,
            roll_out(arm, gaps, starts, {{{}}}, {{kSubsteps}, 10})[0].q);
}

TEST(RollOut, MeasuredTemperatureReachesTheLaws) {
  friction::JointSpec spec{{{"coulomb_viscous", 0, {{"temperature", 1}}}}};
  Arm arm = flywheel(0.3, 0.8);
  arm.friction =
      make_friction(1, spec, [](int, std::string_view, std::string_view) { return std::nan(""); });
  std::vector<Trajectory> cold{spinning(arm, 0.5, 50)}, warm = cold;
  warm[0].data.temperature = RowMatrix::Constant(50, 1, kRoomTemperature + 30);
  const std::vector<Start> starts{{0, 0, 49}};
  EXPECT_NE(roll_out(arm, cold, starts, {{{}}}, {{kSubsteps}, 10})[0].q,
            roll_out(arm, warm, starts, {{{}}}, {{kSubsteps}, 10})[0].q);
}

// A wheel that is driven away crosses the limit once; its lane mate is not disturbed.
TEST(RollOut, DivergedRolloutIsFlaggedClampedAndFinite) {
  const Arm arm = flywheel(0.3, 0.8);
  std::vector<Trajectory> trajectories{spinning(arm, 0.5, 200), spinning(arm, 0.5, 200)};
  trajectories[0].data.tau.setConstant(1e3);
  const std::vector<Start> starts{{0, 0, 199}, {1, 0, 199}};
  const double limit = 2;
  const auto rollouts = roll_out(arm, trajectories, starts, {{{}, {}}}, {{kSubsteps}, limit});
  const Rollout& away = rollouts[0];
  ASSERT_TRUE(away.diverged);
  EXPECT_LE((away.q - trajectories[0].truth->q).cwiseAbs().maxCoeff(), limit);
  EXPECT_EQ(away.v(199, 0), 0);
  EXPECT_EQ(away.tau_f(199, 0), 0);
  EXPECT_GT(away.v(5, 0), 1);
  EXPECT_FALSE(rollouts[1].diverged);
  EXPECT_EQ(rollouts[1].q, trajectories[1].truth->q);
}

TEST(SettleDivergence, NotANumberStopsWhereItAppears) {
  const Arm arm = flywheel(0.3, 0.8);
  const Trajectory trajectory = spinning(arm, 0.5, 10);
  const auto& truth = *trajectory.truth;
  Rollout rollout{{0, 0, 9}, false, truth.q, truth.v, truth.tau_f};
  rollout.v(6, 0) = std::numeric_limits<double>::quiet_NaN();
  rollout.q.bottomRows(3).setConstant(std::numeric_limits<double>::infinity());
  evaluate::settle_divergence(rollout, trajectory, 10);
  EXPECT_TRUE(rollout.diverged);
  EXPECT_TRUE(rollout.q.allFinite() && rollout.v.allFinite() && rollout.tau_f.allFinite());
  EXPECT_EQ(rollout.v(5, 0), truth.v(5, 0));
  EXPECT_EQ(rollout.q(6, 0), truth.q(5, 0));
  EXPECT_EQ(rollout.q(9, 0), truth.q(5, 0));
  EXPECT_EQ(rollout.v(6, 0), 0);
}

TEST(RollOut, RefusesWhatDoesNotFit) {
  const Arm arm = flywheel(0.3, 0.8);
  const std::vector<Trajectory> trajectories{spinning(arm, 0.5, 10)};
  const std::vector<Start> one{{0, 0, 9}};
  const std::vector<Start> many(PackD::kLanes + 1, one[0]);
  const std::vector<std::vector<double>> empty(many.size()), wrong{{1.0}};
  EXPECT_THROW(roll_out(arm, trajectories, many, empty, {}), UserError);
  EXPECT_THROW(roll_out(arm, trajectories, one, wrong, {}), UserError);
  const Arm six{hanging_kr6(), kr6_friction("coulomb_viscous")};
  EXPECT_THROW(roll_out(six, trajectories, one, {{{}}}, {}), UserError);
  Arm further = arm;
  further.friction.theta.push_back(1);
  const OpenLoop differ[]{{&arm, &trajectories[0], one[0], {}},
                          {&further, &trajectories[0], one[0], {}}};
  EXPECT_THROW(evaluate::roll_out(differ, {}), UserError);
}

}  // namespace
}  // namespace fricid::test
