#include "fricid/estimate/torque/left_torque.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <Eigen/Cholesky>

namespace fricid::estimate {
namespace {

constexpr double kMostPeriods = 400, kStep = 0.25;  // over the travel
constexpr Eigen::Index kFewestRows = 30;
constexpr int kStretchesOfTravel = 48;

/// Positions of a joint at its rows, its torque as the arm predicts it, and what it leaves.
struct Left {
  Eigen::ArrayXd q;          // [rad]
  Eigen::ArrayXd v;          // [rad/s]
  Eigen::ArrayXd direction;  // sign of the speed
  Eigen::ArrayXd predicted;  // [N m]
  Eigen::VectorXd torque;    // [N m]

  /// 1, sin(n q), cos(n q).
  Eigen::MatrixX3d wave(double n) const {
    Eigen::MatrixX3d X(q.size(), 3);
    X << Eigen::VectorXd::Ones(q.size()), (n * q).sin().matrix(), (n * q).cos().matrix();
    return X;
  }
};

/// Turns the waves of n to those of n + step, whose own waves are `by`.
void turn(Eigen::MatrixX3d& X, const Eigen::MatrixX3d& by) {
  const Eigen::ArrayXd sine = X.col(1).array();
  X.col(1).array() = sine * by.col(2).array() + X.col(2).array() * by.col(1).array();
  X.col(2).array() = X.col(2).array() * by.col(2).array() - sine * by.col(1).array();
}

Left left_of(const ArmTorqueData& data, const Arm& arm, int j) {
  Left left{{}, {}, {}, {}, -data.residual(arm, j)};
  left.predicted = data.joint(j).tau - left.torque;
  left.q.resize(left.torque.size());
  left.v.resize(left.torque.size());
  Eigen::Index r = 0;
  for (std::size_t s = 0; s < data.recordings().size(); ++s)
    for (const int k : data.joint(j).row[s]) {
      left.q[r] = data.recordings()[s].narrow.q(k, j);
      left.v[r++] = data.recordings()[s].narrow.v(k, j);
    }
  left.direction = (left.v < 0).select(-Eigen::ArrayXd::Ones(left.v.size()), 1);
  return left;
}

double variance(const Eigen::VectorXd& x) { return (x.array() - x.mean()).square().mean(); }

/// Share of the variance of `torque` that is gone in `rest`.
double share_of(const Eigen::VectorXd& rest, const Eigen::VectorXd& torque) {
  return std::max(0.0, 1 - variance(rest) / variance(torque));
}

/// Coefficients of the regression of y on the columns of X, of which any may follow from others.
Eigen::VectorXd regressed(const Eigen::MatrixXd& X, const Eigen::VectorXd& y) {
  constexpr double kRidge = 1e-9;  // of columns of unit length
  const Eigen::VectorXd per_size = X.colwise().norm().transpose().cwiseMax(1e-300).cwiseInverse();
  const Eigen::MatrixXd unit = X * per_size.asDiagonal();
  Eigen::MatrixXd H = unit.transpose() * unit;
  H.diagonal().array() += kRidge;
  return per_size.asDiagonal() * H.ldlt().solve(unit.transpose() * y);
}

}  // namespace

PositionWave strongest_wave(const ArmTorqueData& training, const ArmTorqueData& held_out,
                            const Arm& arm, int j) {
  const Left fitted = left_of(training, arm, j), judged = left_of(held_out, arm, j);
  if (std::min(fitted.q.size(), judged.q.size()) < kFewestRows) return {};
  const double travel = fitted.q.maxCoeff() - fitted.q.minCoeff();
  if (!(travel > 0)) return {};
  const double once = 2 * std::numbers::pi / travel;
  PositionWave best{.slides = slides(arm.robot.joints[static_cast<std::size_t>(j)])};
  Eigen::Vector3d of_best;
  double most = 0;
  Eigen::MatrixX3d X = fitted.wave(once);
  const Eigen::MatrixX3d by = fitted.wave(kStep * once);
  for (double n = once; n <= kMostPeriods * once; n += kStep * once, turn(X, by)) {
    const Eigen::Vector3d g = X.transpose() * fitted.torque,
                          found = (X.transpose() * X).ldlt().solve(g);
    if (const double explained = found.dot(g); explained > most) {
      most = explained;
      best.n = n;
      of_best = found;
    }
  }
  if (best.n == 0) return {};
  best.share = share_of(judged.torque - judged.wave(best.n) * of_best, judged.torque);
  return best;
}

LoadedSpeed loaded_speed(const ArmTorqueData& training, const Arm& arm, int j) {
  constexpr double kSlowest = 0.01;  // [rad/s]
  constexpr int kOctaves = 6;
  const Left left = left_of(training, arm, j);
  const Eigen::Index rows = left.torque.size();
  if (rows < kFewestRows) return {};
  const Eigen::ArrayXd load = left.predicted.abs();
  // beside `peak`, the last column is the candidate
  const auto rise = [&](const Eigen::ArrayXd& peak, const Eigen::ArrayXd& candidate) {
    Eigen::MatrixXd X(rows, 7);
    X << Eigen::VectorXd::Ones(rows), left.v.matrix(), left.direction.matrix(),
        (load * left.direction).matrix(), (load.square() * left.direction).matrix(), peak.matrix(),
        candidate.matrix();
    const auto rest = [&](Eigen::Index count) {
      const Eigen::MatrixXd some = X.leftCols(count);
      return std::max((left.torque - some * regressed(some, left.torque)).squaredNorm(), 1e-300);
    };
    return rest(6) / rest(7) - 1;
  };
  LoadedSpeed found;
  const double scale = dynamics::travel_scale(arm.robot.joints[static_cast<std::size_t>(j)]);
  for (int octave = 0; octave <= kOctaves; ++octave) {
    const double vs = scale * std::ldexp(kSlowest, octave);
    const Eigen::ArrayXd peak = left.direction * (-(left.v / vs).square()).exp();
    found.stribeck = std::max(found.stribeck, rise(peak, peak * load));
    // what the peak explains of viscous friction under load is no proof of it
    const double viscous = rise(peak, left.v * load);
    found.viscous = octave == 0 ? viscous : std::min(found.viscous, viscous);
  }
  return found;
}

TightSpot tightest_spot(const ArmTorqueData& training, const ArmTorqueData& held_out,
                        const Arm& arm, int j) {
  const Left fitted = left_of(training, arm, j), judged = left_of(held_out, arm, j);
  if (std::min(fitted.q.size(), judged.q.size()) < kFewestRows) return {};
  const double low = fitted.q.minCoeff(), travel = fitted.q.maxCoeff() - low;
  if (!(travel > 0)) return {};
  const auto stretch_of = [&](double q) {
    return static_cast<Eigen::Index>(
        std::clamp((q - low) / travel * kStretchesOfTravel, 0.0, kStretchesOfTravel - 1.0));
  };
  const double mean = fitted.torque.mean();  // a constant torque is no friction
  Eigen::ArrayXd sum = Eigen::ArrayXd::Zero(kStretchesOfTravel), count = sum;
  for (Eigen::Index r = 0; r < fitted.q.size(); ++r) {
    sum[stretch_of(fitted.q[r])] += fitted.direction[r] * (fitted.torque[r] - mean);
    count[stretch_of(fitted.q[r])] += 1;
  }
  const Eigen::ArrayXd of_stretch = sum / count.max(1);
  Eigen::VectorXd rest = judged.torque;
  for (Eigen::Index r = 0; r < rest.size(); ++r)
    rest[r] -= judged.direction[r] * of_stretch[stretch_of(judged.q[r])];
  TightSpot spot{.share = share_of(rest, judged.torque),
                 .slides = slides(arm.robot.joints[static_cast<std::size_t>(j)])};
  Eigen::Index most = 0;
  spot.more = of_stretch.maxCoeff(&most);
  spot.at = low + (static_cast<double>(most) + 0.5) * travel / kStretchesOfTravel;
  return spot;
}

TorqueBend bend_of(const ArmTorqueData& training, const ArmTorqueData& held_out, const Arm& arm,
                   int j) {
  const Left fitted = left_of(training, arm, j), judged = left_of(held_out, arm, j);
  if (std::min(fitted.q.size(), judged.q.size()) < kFewestRows) return {};
  const double largest = fitted.predicted.abs().maxCoeff();
  if (!(largest > 0)) return {};
  // the last column is the bend
  const auto columns = [&](const Left& left) {
    const Eigen::ArrayXd tau = left.predicted / largest;
    Eigen::MatrixXd X(tau.size(), 5);
    X << Eigen::VectorXd::Ones(tau.size()), tau.matrix(), (left.direction * tau.abs()).matrix(),
        (left.direction * tau.square()).matrix(), tau.cube().matrix();
    return X;
  };
  const Eigen::MatrixXd X = columns(fitted), of_judged = columns(judged);
  const auto rest = [&](Eigen::Index count, Eigen::VectorXd& found) -> Eigen::VectorXd {
    found = regressed(X.leftCols(count), fitted.torque);
    return judged.torque - of_judged.leftCols(count) * found;
  };
  Eigen::VectorXd found;
  const Eigen::VectorXd without = rest(X.cols() - 1, found), with = rest(X.cols(), found);
  return {.at_largest = found[X.cols() - 1] / largest, .share = share_of(with, without)};
}

}  // namespace fricid::estimate
