#include "rigid_body/inertia_prior.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "fricid/base/eigen_instances.hpp"
#include "rigid_body/information.hpp"

namespace fricid::estimate {
namespace {

constexpr double kGuess = 3;    // standard deviation of a guess over itself
constexpr double kHeld = 1e-3;  // .. of a held armature

// Relative standard deviation of joint i's value, stated or one of the guesses.
double width(double stated, const std::vector<int>& guesses, int i) {
  return std::ranges::count(guesses, i) > 0 ? std::max(stated, kGuess) : stated;
}

// So wide that it only decides what the data leave open.
PriorOptions wide_prior() {
  PriorOptions wide;
  wide.mass = 1, wide.com_m = 0.2, wide.inertia = 1, wide.armature = 10;
  return wide;
}

}  // namespace

Eigen::MatrixXd prior_covariance(const dynamics::RobotModel& robot, const PriorOptions& prior,
                                 const dynamics::Guesses& guesses, const std::vector<int>& held) {
  const int n = robot.n(), p = robot.linear_begin();
  // Entry e of (Ixx, Ixy, Iyy, Ixz, Iyz, Izz) is at row[e], column[e].
  const std::array<int, 6> row{0, 0, 1, 0, 1, 2}, column{0, 1, 1, 2, 2, 2}, diagonal{0, 2, 5};
  // Entry e of the symmetric bilinear form of x'x 1 - x x'.
  const auto steiner = [&](const Eigen::Vector3d& x, const Eigen::Vector3d& y, std::size_t e) {
    const double trace = row[e] == column[e] ? x.dot(y) : 0;
    return trace - 0.5 * (x[row[e]] * y[column[e]] + y[row[e]] * x[column[e]]);
  };
  Eigen::MatrixXd P = Eigen::MatrixXd::Zero(p, p);
  for (int i = 0; i < n; ++i) {
    // pi of the link from (m, c, Ic): mc = m c, I = Ic + m (c'c 1 - c c').
    const Eigen::VectorXd pi = robot.pi.segment<10>(10 * i);
    const double m = pi[0];
    const Eigen::Vector3d c = pi.segment<3>(1) / m;
    Eigen::MatrixXd J = Eigen::MatrixXd::Identity(10, 10);
    J.block<3, 1>(1, 0) = c;
    J.block<3, 3>(1, 1) = m * Eigen::Matrix3d::Identity();
    std::array<double, 6> central{};
    for (std::size_t e = 0; e < 6; ++e) {
      const auto at = static_cast<Eigen::Index>(4 + e);
      J(at, 0) = steiner(c, c, e);
      for (int k = 0; k < 3; ++k) J(at, 1 + k) = 2 * m * steiner(c, Eigen::Vector3d::Unit(k), e);
      central[e] = pi[at] - m * steiner(c, c, e);
    }
    Eigen::VectorXd sd(10);
    sd[0] = prior.mass * m;
    sd.segment<3>(1).setConstant(prior.com_m);
    for (std::size_t e = 0; e < 6; ++e) {
      const double first =
          central[static_cast<std::size_t>(diagonal[static_cast<std::size_t>(row[e])])];
      const double second =
          central[static_cast<std::size_t>(diagonal[static_cast<std::size_t>(column[e])])];
      sd[static_cast<Eigen::Index>(4 + e)] =
          width(prior.inertia, guesses.inertia, i) *
          std::sqrt(std::max(0.0, first) * std::max(0.0, second));
    }
    P.block<10, 10>(10 * i, 10 * i) = J * sd.cwiseAbs2().asDiagonal() * J.transpose();
    const int k = robot.armature_begin() + i;
    const double armature =
        std::ranges::count(held, i) > 0 ? kHeld : width(prior.armature, guesses.armature, i);
    P(k, k) = std::pow(armature * robot.pi[k], 2);
  }
  return P;
}

Eigen::MatrixXd prior_precision(const dynamics::RobotModel& robot,
                                const RigidBodyOptions& options) {
  const int p = robot.parameter_count(), body = robot.linear_begin();
  Eigen::MatrixXd P = prior_covariance(robot, options.prior.use ? options.prior : wide_prior(),
                                       options.guesses, options.held_armatures);
  P.diagonal() *= 1 + 1e-9;
  P.diagonal().array() += 1e-18;
  Eigen::MatrixXd precision = Eigen::MatrixXd::Zero(p, p);
  precision.topLeftCorner(body, body) = invert(P, nullptr);
  for (std::size_t i = 0; i < options.linear_prior_sd.size(); ++i)
    if (const double sd = options.linear_prior_sd[i]; std::isfinite(sd)) {
      const int k = body + static_cast<int>(i);
      precision(k, k) = 1 / (sd * sd);
    }
  return precision;
}

Eigen::MatrixXd held_scores(const dynamics::RobotModel& robot, const RigidBodyOptions& options) {
  const auto held = std::ssize(options.held_armatures);
  Eigen::MatrixXd scores(robot.parameter_count(), held);
  if (held == 0) return scores;
  const Eigen::MatrixXd precision = prior_precision(robot, options);
  for (Eigen::Index i = 0; i < held; ++i) {
    const int joint = options.held_armatures[static_cast<std::size_t>(i)];
    const int k = robot.armature_begin() + joint;
    scores.col(i) = precision.col(k) *
                    (width(options.prior.armature, options.guesses.armature, joint) * robot.pi[k]);
  }
  return scores;
}

Eigen::MatrixXd weak_pull(const dynamics::RobotModel& robot, const dynamics::Guesses& guesses) {
  const int body = robot.linear_begin();
  Eigen::MatrixXd P = prior_covariance(robot, wide_prior(), guesses);
  P.diagonal().array() += 1e-9 * P.diagonal().array() + 1e-12;
  Eigen::MatrixXd root = Eigen::MatrixXd::Zero(robot.parameter_count(), robot.parameter_count());
  root.topLeftCorner(body, body) = inverse_root(P);
  return root;
}

}  // namespace fricid::estimate
