#include "fricid/estimate/couplings.hpp"

#include <algorithm>
#include <array>
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
// Factors of the other joint's speed that are tried; the best is varied. Where it goes beyond the
// outermost, the friction is that of one motor, of which a little of another speed mimics the lag.
constexpr std::array kFactors{1.0, 0.5, 2.0};
constexpr double kLargest = 4;
constexpr double kFirstStep = 1.3, kLastStep = 1.005;
constexpr double kOne = 0.03;  // from 1, within which a factor is taken for 1

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

/// Varies the factor of a coupling while that explains more.
/// @param consider  takes another factor where it explains more
/// @return whether the best lies among those that motors have
template <class Consider>
bool refine(Coupling& best, const Consider& consider) {
  for (double step = kFirstStep; step > kLastStep; step = std::sqrt(step))
    for (double before = 0; before != best.factor;) {
      before = best.factor;
      consider(best.with, before * step);
      consider(best.with, before / step);
      if (const double size = std::abs(best.factor); std::max(size, 1 / size) > kLargest)
        return false;
    }
  if (std::abs(std::abs(best.factor) - 1) < kOne) best.factor = std::copysign(1, best.factor);
  return true;
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
    if (!(own.held_out > 0)) continue;
    const auto turn_with = [&](int k, double factor) {
      X.col(4) = rows.v.col(j) + factor * rows.v.col(k);
      X.col(3) = X.col(4).array().sign().matrix();
    };
    const auto share = [&] { return 1 - left_by(X, rows.torque).held_out / own.held_out; };
    const auto consider = [&](int k, double factor) {
      turn_with(k, factor);
      if (!jumps_with_motor(rows, X)) return;
      if (const double now = share(); now > best.share) best = {k, factor, now, best.r2};
    };
    for (int k = 0; k < n; ++k)
      for (const double factor : kFactors)
        for (const double sign : {1.0, -1.0})
          if (k != j) consider(k, sign * factor);
    if (best.with >= 0 && !refine(best, consider)) best = {.r2 = best.r2};
  }
  return found;
}

bool matters(const Coupling& coupling, double r2) {
  return coupling.share > kCoupled && r2 < kExplained;
}

const std::string& name_of_other(const Coupling& coupling, const dynamics::RobotModel& robot) {
  return robot.joints[static_cast<std::size_t>(coupling.with)].name;
}

double declared_factor(const Coupling& coupling, int joint) {
  return -(joint > coupling.with ? coupling.factor : 1 / coupling.factor);
}

std::string declaration_of(const Coupling& coupling, int joint, const dynamics::RobotModel& robot) {
  const auto [outer, inner] = std::minmax(joint, coupling.with, std::greater());
  return fmt::format("[[robot.coupling]] joint = \"{}\", motor = \"{}\", factor = {:.3g}",
                     robot.joints[static_cast<std::size_t>(outer)].name,
                     robot.joints[static_cast<std::size_t>(inner)].name,
                     declared_factor(coupling, joint));
}

}  // namespace fricid::estimate
