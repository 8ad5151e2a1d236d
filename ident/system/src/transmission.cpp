#include "fricid/system/transmission.hpp"

namespace fricid {
namespace {

/// x B', with 0 * NaN = 0 for zeros of B.
RowMatrix times_transposed(ConstRowMatrix x, const Eigen::MatrixXd& B) {
  if (B.size() == 0 || x.size() == 0) return x;
  RowMatrix out = RowMatrix::Zero(x.rows(), x.cols());
  for (Eigen::Index i = 0; i < B.rows(); ++i)
    for (Eigen::Index k = 0; k < B.cols(); ++k)
      if (B(i, k) != 0) out.col(i) += B(i, k) * x.col(k);
  return out;
}

}  // namespace

Transmission::Transmission(const dynamics::RobotModel& robot) {
  if (!robot.coupled()) return;
  A_ = robot.joints_of_motors();
  C_ = robot.motors_of_joints();
}

RowMatrix Transmission::to_motors(ConstRowMatrix q) const { return times_transposed(q, C_); }
RowMatrix Transmission::to_joints(ConstRowMatrix m) const { return times_transposed(m, A_); }
RowMatrix Transmission::torque_to_motors(ConstRowMatrix tau) const {
  return times_transposed(tau, A_.transpose());
}
RowMatrix Transmission::torque_to_joints(ConstRowMatrix tau_m) const {
  return times_transposed(tau_m, C_.transpose());
}

signals::Dataset Transmission::to_motors(signals::Dataset log) const {
  if (!coupled()) return log;
  log.q = to_motors(log.q);
  log.v = to_motors(log.v);
  log.tau = torque_to_motors(log.tau);
  return log;
}

}  // namespace fricid
