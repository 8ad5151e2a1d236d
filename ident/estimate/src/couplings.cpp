#include "fricid/estimate/couplings.hpp"

#include <algorithm>
#include <cmath>
#include <functional>

#include <fmt/format.h>

#include "rigid_body/information.hpp"

namespace fricid::estimate {
namespace {

constexpr double kApart = 0.02;      // [s] between samples that are looked at
constexpr double kCoupled = 0.4;     // share of a joint's residual
constexpr double kExplained = 0.97;  // R2 above which a coupling does not matter
constexpr int kStretches = 5;        // of the rows, each predicted from the others
constexpr int kJump = 5;             // samples over which a torque jumps as a motor reverses
constexpr double kSure = 4;          // standard errors of that jump

Eigen::VectorXd least_squares(Eigen::MatrixXd H, const Eigen::VectorXd& g) {
  H.diagonal() *= 1 + 1e-9;
  return invert(H, nullptr) * g;
}

/// Squares that regressions of y on the columns of X leave.
struct Left {
  double fitted = 0;    ///< of the rows that they were fitted to
  double held_out = 0;  ///< of each stretch of the rows, by a regression on the others
};

Left left_by(const Eigen::MatrixXd& X, const Eigen::VectorXd& y) {
  const Eigen::MatrixXd H = X.transpose() * X;
  const Eigen::VectorXd g = X.transpose() * y;
  Left left{(y - X * least_squares(H, g)).squaredNorm()};
  for (Eigen::Index stretch = 0; stretch < kStretches; ++stretch) {
    const Eigen::Index begin = X.rows() * stretch / kStretches,
                       rows = X.rows() * (stretch + 1) / kStretches - begin;
    const auto Xs = X.middleRows(begin, rows);
    const auto ys = y.segment(begin, rows);
    const Eigen::VectorXd of_others =
        least_squares(H - Xs.transpose() * Xs, g - Xs.transpose() * ys);
    left.held_out += (ys - Xs * of_others).squaredNorm();
  }
  return left;
}

/// Torque that the rigid body leaves of one joint, beside the speeds of all.
struct Rows {
  Eigen::MatrixXd v;                 ///< (rows, n) [rad/s]
  Eigen::VectorXd torque;            ///< (rows) [N m]
  std::vector<Eigen::Index> before;  ///< row kJump samples earlier in the same recording; -1: none
  double variance = 0;               ///< of the whole torque, times rows [N^2 m^2]
};

Rows rows_of(int j, std::span<const signals::Recording> recordings, const FrictionTorques& target) {
  std::vector<Eigen::RowVectorXd> speeds;
  std::vector<double> torques;
  Rows rows;
  double sum = 0, square = 0;
  for (std::size_t s = 0; s < recordings.size(); ++s) {
    const signals::Recording& r = recordings[s];
    const int every = std::max(1, static_cast<int>(std::lround(kApart / r.dt)));
    std::vector<Eigen::Index> row_of;  // of each sample that is looked at; -1: not used
    for (int k = 0; k < r.length(); k += every) {
      row_of.push_back(r.use(k, j) ? std::ssize(torques) : -1);
      if (!r.use(k, j)) continue;
      const std::ptrdiff_t earlier = std::ssize(row_of) - 1 - kJump;
      rows.before.push_back(earlier < 0 ? -1 : row_of[static_cast<std::size_t>(earlier)]);
      speeds.push_back(r.wide.v.row(k));
      torques.push_back(target[s](k, j));
      sum += r.filtered_tau(k, j), square += std::pow(r.filtered_tau(k, j), 2);
    }
  }
  const auto count = static_cast<Eigen::Index>(torques.size());
  rows.torque = Eigen::Map<const Eigen::VectorXd>(torques.data(), count);
  rows.v.resize(count, recordings.front().n());
  for (Eigen::Index i = 0; i < count; ++i) rows.v.row(i) = speeds[static_cast<std::size_t>(i)];
  rows.variance = square - sum * sum / static_cast<double>(count);
  return rows;
}

/// Whether the torque jumps as a motor reverses that may turn the joint too: regression of
/// differences over kJump samples, in which faults of the rigid body, which change slowly, nearly
/// cancel.
/// @param X  sign and speed of the joint, a constant, sign and speed of the motor
bool jumps_with_motor(const Rows& rows, const Eigen::MatrixXd& X) {
  constexpr Eigen::Index kJoint = 2, kSignOfMotor = 3;
  Eigen::MatrixXd H = Eigen::MatrixXd::Zero(4, 4);
  Eigen::VectorXd g = Eigen::VectorXd::Zero(4);
  double square = 0, count = 0;
  for (std::size_t i = 0; i < rows.before.size(); ++i) {
    const Eigen::Index now = static_cast<Eigen::Index>(i), then = rows.before[i];
    if (then < 0) continue;
    Eigen::Vector4d x;
    x << (X.row(now) - X.row(then)).head<kJoint>().transpose(),
        (X.row(now) - X.row(then)).segment<2>(kSignOfMotor).transpose();
    const double y = rows.torque[now] - rows.torque[then];
    H += x * x.transpose();
    g += x * y;
    square += y * y;
    ++count;
  }
  if (count < 10) return false;
  H.diagonal() *= 1 + 1e-9;
  const Eigen::MatrixXd inverse = invert(H, nullptr);
  const Eigen::VectorXd found = inverse * g;
  const double error_square = kJump * (square - found.dot(g)) / count;  // differences overlap
  return found[kJoint] > kSure * std::sqrt(std::max(0.0, error_square) * inverse(kJoint, kJoint));
}

}  // namespace

std::vector<Coupling> find_couplings(std::span<const signals::Recording> recordings,
                                     const FrictionTorques& target) {
  const int n = recordings.front().n();
  std::vector<Coupling> found(static_cast<std::size_t>(n));
  for (int j = 0; j < n; ++j) {
    const Rows rows = rows_of(j, recordings, target);
    const Eigen::Index count = rows.torque.size();
    if (count < 10) continue;
    Eigen::MatrixXd X(count, 5);
    X.leftCols(3) << rows.v.col(j).array().sign().matrix(), rows.v.col(j),
        Eigen::VectorXd::Ones(count);
    const Left own = left_by(X.leftCols(3), rows.torque);
    Coupling& best = found[static_cast<std::size_t>(j)];
    best.r2 = 1 - own.fitted / rows.variance;
    for (int k = 0; k < n; ++k)
      for (const double sign : {1.0, -1.0}) {
        if (k == j || !(own.held_out > 0)) continue;
        X.col(4) = rows.v.col(j) + sign * rows.v.col(k);
        X.col(3) = X.col(4).array().sign().matrix();
        if (!jumps_with_motor(rows, X)) continue;
        const double share = 1 - left_by(X, rows.torque).held_out / own.held_out;
        if (share > best.share) best = {k, sign, share, best.r2};
      }
  }
  return found;
}

bool matters(const Coupling& coupling, double r2) {
  return coupling.share > kCoupled && r2 < kExplained;
}

const std::string& name_of_other(const Coupling& coupling, const dynamics::RobotModel& robot) {
  return robot.joints[static_cast<std::size_t>(coupling.with)].name;
}

std::string declaration_of(const Coupling& coupling, int joint, const dynamics::RobotModel& robot) {
  const auto [outer, inner] = std::minmax(joint, coupling.with, std::greater());
  return fmt::format("[[robot.coupling]] joint = \"{}\", motor = \"{}\", factor = {:g}",
                     robot.joints[static_cast<std::size_t>(outer)].name,
                     robot.joints[static_cast<std::size_t>(inner)].name, -coupling.sign);
}

}  // namespace fricid::estimate
