#include "rigid_body/tilt.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include <Eigen/Geometry>

#include "fricid/base/eigen_instances.hpp"
#include "fricid/dynamics/algorithms.hpp"

namespace fricid::estimate {
namespace {

constexpr double kLeastGain = 0.1;    // log of the variance of a joint
constexpr double kLeastTilt = 0.02;   // [rad]
constexpr double kCertainTilt = 6;    // standard errors
constexpr int kStepsOfTilt = 4;       // of Gauss-Newton
constexpr double kLargestStep = 0.5;  // [rad]

using Directions = Eigen::Matrix<double, 3, 2>;

/// G [N m / (m/s^2)] in the rows of each joint (N_j x 3): the torque of gravity (1, 0, 0) and so
/// on on bodies pi.
std::vector<Eigen::MatrixXd> torque_by_gravity(const dynamics::RobotModel& robot,
                                               const StackedByJoint& all, const Eigen::VectorXd& x,
                                               std::span<const signals::Recording> recordings) {
  const auto n = static_cast<std::size_t>(robot.n());
  Eigen::VectorXd pi = all.standard(x, robot.parameter_count());
  pi.tail(robot.parameter_count() - robot.armature_begin()).setZero();
  std::vector<dynamics::RobotModel> under(3, robot);
  for (int k = 0; k < 3; ++k) under[static_cast<std::size_t>(k)].gravity = Eigen::Vector3d::Unit(k);
  dynamics::Workspace<double> ws(robot);
  const std::vector<double> still(n, 0.0);
  return rows_by_sample(all, 3, [&](int sequence, int sample, RowMatrix& of_sample) {
    const RowMatrix& q = recordings[static_cast<std::size_t>(sequence)].narrow.q;
    for (int k = 0; k < 3; ++k)
      dynamics::rnea<double>(under[static_cast<std::size_t>(k)], ws,
                             {pi.data(), static_cast<std::size_t>(pi.size())},
                             {q.row(sample).data(), n}, still, still, {of_sample.row(k).data(), n});
  });
}

/// Standard error [rad] of a turn towards delta, by the jackknife.
double error_of(const StackedByJoint& all, const Solution& found, const Eigen::Vector2d& towards) {
  const Eigen::MatrixXd none = Eigen::MatrixXd::Zero(all.size, all.size);
  return (towards.transpose() * jackknife_root(all, found.x, found.sigma, none).bottomRows(2))
      .norm();
}

}  // namespace

std::optional<Tilt> find_tilt(const dynamics::RobotModel& robot, const StackedByJoint& stacked,
                              std::span<const signals::Recording> recordings,
                              const RigidBodyOptions& options) {
  if (robot.gravity.isZero()) return std::nullopt;
  dynamics::RobotModel turned = robot;
  StackedByJoint all = with_curves(stacked);
  Solution plain = solve(all, all.plain);
  const Eigen::VectorXd before = plain.sigma;
  Tilt tilt;
  for (int step = 0; step < kStepsOfTilt; ++step) {
    if (step > 0) {
      all = with_curves(stack_by_joint(turned, recordings, options));
      plain = solve(all, all.plain);
    }
    const Eigen::Vector3d across = turned.gravity.unitOrthogonal(),
                          other = turned.gravity.normalized().cross(across);
    Directions directions;
    directions << across.cross(turned.gravity), other.cross(turned.gravity);
    std::vector<Eigen::MatrixXd> of_directions =
        torque_by_gravity(turned, all, plain.x, recordings);
    for (Eigen::MatrixXd& of_joint : of_directions) of_joint = (of_joint * directions).eval();
    const StackedByJoint with = with_columns(all, of_directions);
    const Solution found = solve(with, with.plain);
    const Eigen::Vector2d delta = found.x.tail(2);
    const double angle = delta.norm();
    if (!(angle > 0) || !std::isfinite(angle)) return std::nullopt;
    tilt.standard_error = error_of(with, found, delta / angle);
    tilt.gain = gain_of(before, found.sigma);
    const double most = 2 * (before.array() / found.sigma.array()).log().maxCoeff();
    if (step == 0 && !(most > kLeastGain && angle > kCertainTilt * tilt.standard_error))
      return std::nullopt;
    const Eigen::Vector3d axis = (delta[0] * across + delta[1] * other) / angle;
    turned.gravity = Eigen::AngleAxisd(std::min(angle, kLargestStep), axis) * turned.gravity;
  }
  tilt.gravity = turned.gravity;
  tilt.angle =
      std::atan2(robot.gravity.cross(turned.gravity).norm(), robot.gravity.dot(turned.gravity));
  if (!(tilt.angle > std::max(kLeastTilt, kCertainTilt * tilt.standard_error))) return std::nullopt;
  return tilt;
}

}  // namespace fricid::estimate
