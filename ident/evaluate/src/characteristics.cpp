#include "fricid/evaluate/characteristics.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

namespace fricid::evaluate {
namespace {

constexpr double kFastEnough = 0.15;  // [rad/s]

RowMatrix without_load(const friction::Friction& friction, double dt, const RowMatrix& q,
                       const RowMatrix& v) {
  return drive_friction(friction, dt, q, v, RowMatrix::Zero(q.rows(), q.cols()), RowMatrix()).tau_f;
}

}  // namespace

Eigen::VectorXd presliding_length(const friction::Friction& friction) {
  constexpr int kSteps = 5000;
  constexpr double kFar = 0.05, kSpeed = 0.01;  // [rad], [rad/s]
  const int n = friction.model.joint_count();
  const Eigen::VectorXd x = Eigen::VectorXd::LinSpaced(kSteps, 0, kFar);
  const RowMatrix tau_f =
      without_load(friction, kFar / kSpeed / kSteps, x * Eigen::RowVectorXd::Ones(n),
                   RowMatrix::Constant(kSteps, n, kSpeed));
  Eigen::VectorXd length(n);
  for (int j = 0; j < n; ++j) {
    int k = 0;
    while (k + 1 < kSteps && tau_f(k, j) < 0.9 * tau_f(kSteps - 1, j)) ++k;
    length[j] = x[k];
  }
  return length;
}

PreslidingMotion presliding_motion(const Eigen::VectorXd& amplitude) {
  constexpr std::array kTurns{0.0, 1.0, -1.0, 0.25, -0.35, 1.0};
  constexpr int kSteps = 500;             // per unit of amplitude
  constexpr double kDt = 0.002;           // [s]
  std::vector<double> share{0.0}, speed;  // amplitudes, amplitudes per second
  for (std::size_t leg = 1; leg < kTurns.size(); ++leg) {
    const double from = kTurns[leg - 1], way = kTurns[leg] - from;
    const int steps = static_cast<int>(std::lround(kSteps * std::abs(way)));
    for (int k = 1; k <= steps; ++k) {
      share.push_back(from + way * k / steps);
      speed.push_back(way / (steps * kDt));
    }
  }
  speed.push_back(speed.back());
  const Eigen::Map<const Eigen::VectorXd> x(share.data(), std::ssize(share)),
      rate(speed.data(), std::ssize(speed));
  return {x * amplitude.transpose(), rate * amplitude.transpose(), kDt};
}

PreslidingMotion presliding_motion_through(std::span<const friction::Friction> frictions) {
  constexpr double kBeyond = 1.5, kShortest = 1e-4;  // of the length, [rad]
  Eigen::VectorXd amplitude =
      Eigen::VectorXd::Constant(frictions.front().model.joint_count(), kBeyond * kShortest);
  for (const friction::Friction& friction : frictions) {
    const Eigen::VectorXd length = presliding_length(friction);
    for (Eigen::Index j = 0; j < length.size(); ++j)
      amplitude[j] = std::max(amplitude[j], kBeyond * length[j]);
  }
  return presliding_motion(amplitude);
}

RowMatrix presliding_loop(const friction::Friction& friction, const PreslidingMotion& motion) {
  return without_load(friction, motion.dt, motion.q, motion.v);
}

Eigen::Index slowest_reversal(const Eigen::VectorXd& v, double dt) {
  const auto side = static_cast<Eigen::Index>(std::lround(kAroundReversal / dt));
  Eigen::Index best = -1;
  double least = INFINITY;
  for (Eigen::Index k = side; k + side + 1 < v.size(); ++k) {
    if ((v[k] > 0) == (v[k + 1] > 0)) continue;
    if (std::abs(v[k - side]) < kFastEnough || std::abs(v[k + side]) < kFastEnough) continue;
    if ((v[k - side] > 0) == (v[k + side] > 0)) continue;
    const double acceleration = std::abs(v[k + 1] - v[k]);
    if (acceleration < least) {
      least = acceleration;
      best = k;
    }
  }
  return best;
}

}  // namespace fricid::evaluate
