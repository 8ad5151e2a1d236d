#include "fricid/estimate/torque/cable.hpp"

#include <algorithm>

#include <Eigen/Cholesky>

namespace fricid::estimate {
namespace {

constexpr double kLengths[] = {0.1, 0.2, 0.4, 0.8, 1.6, 3.2};  // [rad]
constexpr double kRidge = 1e-9;  // of Y'Y: parameters that the motion does not show

/// z of a spring that is relaxed where each recording begins, at the rows of joint j.
Eigen::VectorXd motion_of_spring(const ArmTorqueData& data, int j, double length) {
  const ArmTorqueData::Joint& joint = data.joint(j);
  Eigen::VectorXd z(joint.tau.size());
  Eigen::Index r = 0;
  for (std::size_t s = 0; s < joint.row.size(); ++s) {
    const RowMatrix& q = data.recordings()[s].wide.q;
    double at = 0;
    int k = 0;
    for (const int row : joint.row[s]) {
      for (; k < row; ++k) at = std::clamp(at + q(k + 1, j) - q(k, j), -length, length);
      z[r++] = at;
    }
  }
  return z;
}

}  // namespace

Cable strongest_cable(const ArmTorqueData& data, const Arm& arm, int j) {
  const ArmTorqueData::Joint& joint = data.joint(j);
  const Eigen::VectorXd left = -data.residual(arm, j);  // of tau
  const double size = left.squaredNorm();
  Eigen::MatrixXd YY = joint.YY;
  YY.diagonal().array() += kRidge * YY.trace() + 1e-300;
  const Eigen::LDLT<Eigen::MatrixXd> rigid_body(YY);
  const double scale = dynamics::travel_scale(arm.robot.joints[static_cast<std::size_t>(j)]);
  Cable best;
  for (const double length : kLengths) {
    const Eigen::VectorXd z = motion_of_spring(data, j, length * scale);
    const Eigen::VectorXd own = z - joint.Y * rigid_body.solve(joint.Y.transpose() * z);
    const double K = own.dot(left) / std::max(own.squaredNorm(), 1e-300);
    const double rest = std::max((left - K * own).squaredNorm(), 1e-300);
    if (const double gain = size / rest - 1; K > 0 && gain > best.gain)
      best = {length * scale, K, gain};
  }
  return best;
}

}  // namespace fricid::estimate
