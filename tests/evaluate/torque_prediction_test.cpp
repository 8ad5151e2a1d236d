#include "fricid/evaluate/torque_prediction.hpp"

#include <gtest/gtest.h>

#include <limits>

#include "contest.hpp"
#include "fricid/base/error.hpp"

namespace fricid::test {
namespace {

using evaluate::torque_prediction;
using evaluate::TorquePrediction;

/// A recording at one step per sample and the acceleration that its torque makes.
struct Moving {
  Arm arm;
  evaluate::Trajectory trajectory;
  RowMatrix a;
  explicit Moving(friction::Friction friction) : arm{hanging_kr6(), std::move(friction)} {
    const Recording recording = record(arm, HangingMotion(5), 500, {1});
    trajectory = as_trajectory(recording, "validation_0");
    a.resize(500, 6);
    dynamics::Workspace<double> ws(arm.robot);
    const std::span<const double> pi(arm.robot.pi.data(),
                                     static_cast<std::size_t>(arm.robot.pi.size()));
    const RowMatrix net = recording.tau - recording.tau_f;
    for (Eigen::Index k = 0; k < 500; ++k)
      dynamics::forward_dynamics<double>(arm.robot, ws, pi, {recording.q.row(k).data(), 6},
                                         {recording.v.row(k).data(), 6}, {net.row(k).data(), 6},
                                         {a.row(k).data(), 6});
  }
  TorquePrediction predict(const Arm& model) const {
    return torque_prediction(model, arm.robot, trajectory.data, trajectory.q, trajectory.v, a);
  }
};

// The first state is an estimate; what is wrong with it is soon forgotten.
TEST(TorquePrediction, TrueModelOnItsOwnMotionIsExactOnceUnderWay) {
  const Moving moving(kr6_friction("lugre"));
  const TorquePrediction prediction = moving.predict(moving.arm);
  const RowMatrix error = prediction.tau - moving.trajectory.data.tau;
  EXPECT_LT(error.bottomRows(250).cwiseAbs().maxCoeff(), 1e-7);
  for (std::size_t j = 0; j < 6; ++j) EXPECT_LT(prediction.percent_of_rms[j], 0.1);
}

// Without its friction a model errs by the true friction torque: RMSE, % of RMS and R2 by hand.
TEST(TorquePrediction, FiguresByHand) {
  const Moving moving(kr6_friction("lugre"));
  const Arm bare{moving.arm.robot,
                 {friction::RobotFriction(std::vector<friction::JointSpec>(6)), {}}};
  const TorquePrediction prediction = moving.predict(bare);
  EXPECT_EQ(prediction.tau_f, RowMatrix::Zero(500, 6));
  const RowMatrix& tau = moving.trajectory.data.tau;
  for (Eigen::Index j = 0; j < 6; ++j) {
    const auto i = static_cast<std::size_t>(j);
    const double error = moving.trajectory.truth->tau_f.col(j).squaredNorm();
    const double power = tau.col(j).squaredNorm();
    const double variance = (tau.col(j).array() - tau.col(j).mean()).square().sum();
    EXPECT_NEAR(prediction.rmse.all[i], std::sqrt(error / 500), 1e-9);
    EXPECT_NEAR(prediction.percent_of_rms[i], 100 * std::sqrt(error / power), 1e-8);
    EXPECT_NEAR(prediction.r2[i], 1 - error / variance, 1e-9);
  }
}

TEST(TorquePrediction, ConstantTorqueIsPartOfTheFrictionOnce) {
  const Moving moving(kr6_friction("lugre"));
  Arm offset = moving.arm;
  dynamics::add_linear_torque(offset.robot, {"offset", 2}, 0.7);
  const TorquePrediction with = moving.predict(offset), without = moving.predict(moving.arm);
  // the first state, from the torque balance, differs; later rows have forgotten it
  for (const auto& difference : {RowMatrix((with.tau - without.tau).bottomRows(250)),
                                 RowMatrix((with.tau_f - without.tau_f).bottomRows(250))}) {
    EXPECT_NEAR(difference.col(2).minCoeff(), 0.7, 1e-9);
    EXPECT_NEAR(difference.col(2).maxCoeff(), 0.7, 1e-9);
    EXPECT_LT(difference.col(1).norm(), 1e-9);
  }
}

TEST(TorquePrediction, LeavesOutMissingTorque) {
  Moving moving(kr6_friction("lugre"));
  const Arm bare{moving.arm.robot, kr6_friction("coulomb_viscous")};
  moving.trajectory.data.tau.topRows(499).setConstant(std::numeric_limits<double>::quiet_NaN());
  const TorquePrediction prediction = moving.predict(bare);
  EXPECT_NEAR(prediction.rmse.all[2],
              std::abs(prediction.tau(499, 2) - moving.trajectory.data.tau(499, 2)), 1e-12);
}

// A law that depends on load must predict without looking at the torque to be predicted.
TEST(TorquePrediction, DoesNotPeekAtTheMeasuredTorque) {
  const friction::Friction loaded =
      make_friction(6, {{{"load_dependent", 0, {}}}},
                    [](int, std::string_view, std::string_view) { return std::nan(""); });
  ASSERT_TRUE(loaded.model.reads_load());
  Moving moving(kr6_friction("lugre"));
  const Arm arm{moving.arm.robot, loaded};
  const RowMatrix before = moving.predict(arm).tau;
  moving.trajectory.data.tau *= 2;
  EXPECT_EQ(moving.predict(arm).tau, before);
}

TEST(TorquePrediction, RefusesWhatDoesNotFit) {
  const Moving moving(kr6_friction("lugre"));
  EXPECT_THROW(torque_prediction(moving.arm, moving.arm.robot, moving.trajectory.data,
                                 moving.trajectory.q, moving.trajectory.v, moving.a.topRows(3)),
               UserError);
  EXPECT_THROW(moving.predict(flywheel(1, 0)), UserError);
}

// A residual e = a + b t + (-1)^k c, added to a prediction that is exact: drift b, and one step
// ahead what the alternation, whose autocorrelation is -1, leaves.
TEST(TorquePrediction, DriftAndOneStepByHand) {
  Moving moving(kr6_friction("coulomb_viscous"));
  const RowMatrix exact = moving.predict(moving.arm).tau;
  data::Dataset& data = moving.trajectory.data;
  for (Eigen::Index k = 0; k < 500; ++k) {
    data.tau.row(k) = exact.row(k);
    data.tau(k, 0) += 2 + 0.5 * data.t[k];
    data.tau(k, 1) += k % 2 == 0 ? 0.1 : -0.1;
  }
  const TorquePrediction prediction = moving.predict(moving.arm);
  EXPECT_NEAR(prediction.drift[0], 0.5 * data.t[499], 1e-9);
  EXPECT_LT(std::abs(prediction.drift[1]), 0.02);
  EXPECT_LT(prediction.drift_error[0], 1e-9);
  EXPECT_NEAR(prediction.rmse.all[1], 0.1, 1e-9);
  EXPECT_LT(prediction.one_step[1], 0.01);
}

}  // namespace
}  // namespace fricid::test
