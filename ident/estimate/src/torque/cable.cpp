#include "fricid/estimate/torque/cable.hpp"

#include <algorithm>
#include <array>

#include <Eigen/Cholesky>

#include "fricid/friction/laws/maxwell_slip.hpp"

namespace fricid::estimate {
namespace {

constexpr double kLengths[] = {0.1, 0.2, 0.4, 0.8, 1.6, 3.2};  // [rad]
constexpr double kUnseenRidge = 1e-9;  // of Y'Y: parameters that the motion does not show

}  // namespace

Cable strongest_cable(const ArmTorqueData& data, const Arm& arm, int j) {
  const ArmTorqueData::Joint& joint = data.joint(j);
  const Eigen::VectorXd left = -data.residual(arm, j);  // of tau
  const double size = left.squaredNorm();
  Eigen::MatrixXd YY = joint.YY;
  YY.diagonal().array() += kUnseenRidge * YY.trace() + 1e-300;
  const Eigen::LDLT<Eigen::MatrixXd> rigid_body(YY);
  const double scale = dynamics::travel_scale(arm.robot.joints[static_cast<std::size_t>(j)]);
  // F[z] of a spring that is relaxed where each recording begins: F of one of 1 N m/rad
  const friction::RobotFriction spring({{{{std::string(friction::MaxwellSlip::kName), 1, {}}}}});
  std::array<double, 2> theta{};
  theta[friction::MaxwellSlip::K(0)] = 1;
  Cable best;
  for (const double length : kLengths) {
    theta[friction::MaxwellSlip::W(0)] = length * scale;
    const Eigen::VectorXd z = joint.predict(spring, theta);
    const Eigen::VectorXd own = z - joint.Y * rigid_body.solve(joint.Y.transpose() * z);
    const double K = own.dot(left) / std::max(own.squaredNorm(), 1e-300);
    const double rest = std::max((left - K * own).squaredNorm(), 1e-300);
    if (const double gain = size / rest - 1; K > 0 && gain > best.gain)
      best = {length * scale, K, gain};
  }
  return best;
}

}  // namespace fricid::estimate
