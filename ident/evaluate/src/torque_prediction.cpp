#include "fricid/evaluate/torque_prediction.hpp"

#include <cmath>

#include "fricid/base/error.hpp"
#include "fricid/base/not_finite.hpp"
#include "fricid/evaluate/constant_friction.hpp"
#include "fricid/evaluate/trajectory.hpp"
#include "fricid/signals/block_means.hpp"
#include "fricid/system/initial_state.hpp"
#include "fricid/system/transmission.hpp"

namespace fricid::evaluate {
namespace {

RowMatrix rigid_body_torque(const dynamics::RobotModel& robot, ConstRowMatrix q, ConstRowMatrix v,
                            ConstRowMatrix a) {
  dynamics::Workspace<double> ws(robot);
  const auto n = static_cast<std::size_t>(robot.n());
  const std::span<const double> pi(robot.pi.data(), static_cast<std::size_t>(robot.pi.size()));
  RowMatrix tau(q.rows(), q.cols());
  for (Eigen::Index k = 0; k < q.rows(); ++k)
    dynamics::rnea<double>(robot, ws, pi, {q.row(k).data(), n}, {v.row(k).data(), n},
                           {a.row(k).data(), n}, {tau.row(k).data(), n});
  return tau;
}

/// Rise over all of e of the least-squares line through its block means, and its standard error.
std::pair<double, double> drift_of(const Eigen::VectorXd& e) {
  const Eigen::Index length = e.size() / kDriftBlocks;
  const Eigen::Array<double, kDriftBlocks, 1> mean = signals::block_means(e, kDriftBlocks);
  Eigen::Array<double, kDriftBlocks, 1> t;  // from 0 at the begin of e to 1 at its end
  for (Eigen::Index b = 0; b < kDriftBlocks; ++b)
    t[b] = (static_cast<double>(b) + 0.5) * static_cast<double>(length) /
           static_cast<double>(e.size() - 1);
  t -= t.mean();
  const double slope = (t * mean).sum() / t.square().sum();
  const double left = (mean - mean.mean() - slope * t).square().sum() / (kDriftBlocks - 2);
  return {slope, std::sqrt(left / t.square().sum())};
}

void score_joint(TorquePrediction& prediction, const RowMatrix& measured, Eigen::Index j) {
  double sum = 0, squares = 0, residual = 0, product = 0, last = kNan;
  int count = 0;
  for (Eigen::Index k = 0; k < measured.rows(); ++k) {
    const double tau = measured(k, j), e = prediction.tau(k, j) - tau;
    if (std::isfinite(tau)) {
      sum += tau;
      squares += tau * tau;
      residual += e * e;
      ++count;
    }
    if (std::isfinite(e * last)) product += e * last;
    last = e;
  }
  const double rho = residual > 0 ? product / residual : 0;
  prediction.one_step.push_back(std::sqrt(residual / count * (1 - rho * rho)));
  prediction.percent_of_rms.push_back(100 * std::sqrt(residual / squares));
  prediction.r2.push_back(1 - residual / (squares - sum * sum / count));
}

}  // namespace

TorquePrediction torque_prediction(const Arm& arm, const dynamics::RobotModel& known,
                                   const data::Dataset& dataset, ConstRowMatrix joint_q,
                                   ConstRowMatrix joint_v, ConstRowMatrix joint_a) {
  const int n = arm.robot.n();
  for (const ConstRowMatrix* motion : {&joint_q, &joint_v, &joint_a})
    if (motion->rows() != dataset.length() || motion->cols() != n || dataset.n() != n)
      throw UserError("{}: motion is {} x {}, torque {} x {}, the model has {} joints",
                      dataset.name, motion->rows(), motion->cols(), dataset.length(), dataset.n(),
                      n);
  const Transmission motors(arm.robot);
  const RowMatrix q = motors.to_motors(joint_q), v = motors.to_motors(joint_v),
                  a = motors.to_motors(joint_a);
  const std::vector<double> z0 = initial_friction_state(
      arm, dataset.dt(), q, v, motors.torque_to_motors(held_torque(dataset)), dataset.temperature);
  const RowMatrix rigid = rigid_body_torque(arm.robot, q, v, a);
  TorquePrediction prediction;
  const RowMatrix tau_f =
      drive_under_own_load(arm.friction, dataset.dt(), q, v, rigid, dataset.temperature, z0).tau_f;
  prediction.tau = motors.torque_to_joints(rigid + tau_f);
  prediction.tau_f = motors.torque_to_joints(tau_f);
  prediction.tau_f.rowwise() += constant_friction(arm.robot, known);
  const RowMatrix left = dataset.tau - prediction.tau;
  prediction.rmse = regime_error(left, joint_q, joint_v, dataset.dt(), 0, arm.robot.joints);
  for (Eigen::Index j = 0; j < n; ++j) {
    score_joint(prediction, dataset.tau, j);
    const auto [slope, error] = drift_of(left.col(j));
    prediction.drift.push_back(slope);
    prediction.drift_error.push_back(error);
  }
  return prediction;
}

RowMatrix driven_states(const Arm& arm, const PredictionSignals& signals) {
  const Transmission motors(arm.robot);
  return drive_friction(arm.friction, signals.t[1] - signals.t[0], motors.to_motors(signals.q),
                        motors.to_motors(signals.v), motors.torque_to_motors(signals.tau),
                        RowMatrix())
      .z;
}

}  // namespace fricid::evaluate
