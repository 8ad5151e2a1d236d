// Signals of a run's files: what was written comes back.
#include <gtest/gtest.h>

#include "fricid/base/error.hpp"
#include "fricid/evaluate/bands.hpp"
#include "fricid/evaluate/rollout.hpp"
#include "fricid/evaluate/torque_prediction.hpp"
#include "temporary_folder.hpp"

namespace fricid::evaluate {
namespace {

class SignalFiles : public TemporaryFolder {
 protected:
  static constexpr int kRows = 6, kJoints = 2;
  const std::filesystem::path file = folder / "signals.h5";
  const RowMatrix q = RowMatrix::Random(kRows, kJoints), v = RowMatrix::Random(kRows, kJoints),
                  tau = RowMatrix::Random(kRows, kJoints);
  Trajectory trajectory;

  void SetUp() override {
    trajectory.data.name = "validation_0";
    trajectory.data.joint_names = {"a", "b"};
    trajectory.data.t = Eigen::VectorXd::LinSpaced(kRows, 0, 1);
    trajectory.data.q = q;
    trajectory.data.tau = tau;
  }
};

TEST_F(SignalFiles, OfARolloutComeBack) {
  const Rollout rollout{
      {0, 2, kRows - 3}, false, q.bottomRows(4), v.bottomRows(4), tau.bottomRows(4)};
  save_rollout(rollout, trajectory, "lugre", 1, file);
  const RolloutSignals read = load_rollout(file, kJoints);
  EXPECT_EQ(read.t, trajectory.data.t.tail(4));
  EXPECT_EQ(read.q, rollout.q);
  EXPECT_EQ(read.v, rollout.v);
  EXPECT_EQ(read.tau_f, rollout.tau_f);
  EXPECT_THROW(load_rollout(file, kJoints + 1), UserError);
  EXPECT_THROW(load_prediction(file, kJoints), UserError);
}

TEST_F(SignalFiles, FrictionThatIsNotKnownIsEmpty) {
  save_rollout({{0, 0, kRows - 1}, false, q, v, {}}, trajectory, "tool", 1, file);
  EXPECT_EQ(load_rollout(file, kJoints).tau_f.size(), 0);
}

TEST_F(SignalFiles, OfAPredictionComeBack) {
  TorquePrediction prediction;
  prediction.tau = 2 * tau;
  prediction.tau_f = 3 * tau;
  save_prediction(prediction, trajectory.data, q, v, file);
  const PredictionSignals read = load_prediction(file, kJoints);
  EXPECT_EQ(read.t, trajectory.data.t);
  EXPECT_EQ(read.q, q);
  EXPECT_EQ(read.v, v);
  EXPECT_EQ(read.tau, tau);
  EXPECT_EQ(read.tau_predicted, prediction.tau);
  EXPECT_EQ(read.tau_f, prediction.tau_f);
}

TEST_F(SignalFiles, OfABandComeBack) {
  save_band({q.topRows(3), v.topRows(3)}, trajectory.data, "lugre", file);
  const BandSignals read = load_band(file, kJoints);
  EXPECT_EQ(read.t, trajectory.data.t.head(3));
  EXPECT_EQ(read.band.low, q.topRows(3));
  EXPECT_EQ(read.band.high, v.topRows(3));
}

TEST_F(SignalFiles, TablesOfOtherLengthAreRefused) {
  TorquePrediction prediction;
  prediction.tau = tau;
  prediction.tau_f = tau.topRows(2);
  save_prediction(prediction, trajectory.data, q, v, file);
  try {
    load_prediction(file, kJoints);
    FAIL() << "not refused";
  } catch (const UserError& error) {
    EXPECT_EQ(error.what(), file.string() + ": table tau_f has 2 rows; allowed: 6, as t");
  }
}

}  // namespace
}  // namespace fricid::evaluate
