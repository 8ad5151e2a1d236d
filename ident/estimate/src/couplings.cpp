#include "fricid/estimate/couplings.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <utility>

#include <fmt/format.h>

#include "rigid_body/information.hpp"

namespace fricid::estimate {
namespace {

constexpr double kApart = 0.02;      // [s] between samples that are looked at
constexpr int kReach = 2;            // joints between which motors are coupled are that close
constexpr double kSlides = 0.1;      // of the joint's speed in root mean square
constexpr double kCoupled = 0.4;     // share of a joint's residual
constexpr double kExplained = 0.97;  // R2 above which a coupling does not matter
constexpr int kStretches = 5;        // of the rows, each predicted from the others
constexpr int kJump = 5;             // samples over which a torque jumps as a motor reverses
constexpr double kSure = 4;          // standard errors of that jump
// Factors of the other joint's speed that are tried; the best is varied. Where it goes beyond the
// outermost, the friction is that of one motor, of which a little of another speed mimics the lag.
constexpr std::array kFactors{1.0, 0.5, 0.25, 2.0};
constexpr double kLargest = 5;
constexpr double kFirstStep = 1.3, kLastStep = 1.005;
constexpr double kHalf = 0.5;
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

/// @param least_speed  of the joint in the rows [rad/s]
Rows rows_of(int j, std::span<const signals::Recording> recordings, const FrictionTorques& target,
             double least_speed) {
  std::vector<Eigen::RowVectorXd> speeds;
  std::vector<double> torques;
  Rows rows;
  double sum = 0, square = 0;
  for (std::size_t s = 0; s < recordings.size(); ++s) {
    const signals::Recording& r = recordings[s];
    const int every = std::max(1, static_cast<int>(std::lround(kApart / r.dt)));
    std::vector<Eigen::Index> row_of;  // of each sample that is looked at; -1: not used
    for (int k = 0; k < r.length(); k += every) {
      const bool used = r.use(k, j) && std::abs(r.wide.v(k, j)) >= least_speed;
      row_of.push_back(used ? std::ssize(torques) : -1);
      if (!used) continue;
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

double rms_speed(std::span<const signals::Recording> recordings, int j) {
  double square = 0, samples = 0;
  for (const signals::Recording& r : recordings) {
    square += r.wide.v.col(j).squaredNorm();
    samples += r.length();
  }
  return std::sqrt(square / samples);
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

/// What sign and speed of two joints together say beside those of one.
class Motors {
 public:
  Motors(Rows rows, int j) : rows_(std::move(rows)), j_(j), X_(rows_.torque.size(), 5) {
    if (!has_rows()) return;
    X_.leftCols(3) << rows_.v.col(j).array().sign().matrix(), rows_.v.col(j),
        Eigen::VectorXd::Ones(X_.rows());
    own_ = left_by(X_.leftCols(3), rows_.torque);
  }

  bool has_rows() const { return rows_.torque.size() >= 10; }
  /// R2 of the joint's own Coulomb and viscous friction.
  double r2() const { return 1 - own_.fitted / rows_.variance; }
  bool leaves_any() const { return own_.held_out > 0; }
  /// Whether sign and speed of the motor at v_j + factor v_k explain less than half of what they
  /// and those of the joint do, beside those of the joint alone.
  bool needs_own(int k, double factor) {
    Eigen::MatrixXd motor(X_.rows(), 3);
    motor.col(1) = rows_.v.col(j_) + factor * rows_.v.col(k);
    motor.col(0) = motor.col(1).array().sign().matrix();
    motor.col(2).setOnes();
    X_.rightCols(2) = motor.leftCols(2);
    return own_.held_out - left_by(motor, rows_.torque).held_out <
           kHalf * (own_.held_out - left_by(X_, rows_.torque).held_out);
  }
  /// What motors at v_j + factor v_k and v_j + second v_k leave, over what the first and the joint
  /// itself do.
  double left_by_two(int k, double factor, double second) {
    Eigen::MatrixXd motors(X_.rows(), 5);
    motors.col(1) = rows_.v.col(j_) + factor * rows_.v.col(k);
    motors.col(3) = rows_.v.col(j_) + second * rows_.v.col(k);
    for (const Eigen::Index motor : {0, 2})
      motors.col(motor) = motors.col(motor + 1).array().sign();
    motors.col(4).setOnes();
    X_.rightCols(2) = motors.leftCols(2);
    return left_by(motors, rows_.torque).held_out / left_by(X_, rows_.torque).held_out;
  }
  /// Share of what that leaves which a motor at v_j + factor v_k explains, `Coupling::share`; none
  /// where the torque does not jump with it.
  double share(int k, double factor) {
    return jumps(k, factor) ? 1 - left_by(X_, rows_.torque).held_out / own_.held_out : 0;
  }
  bool jumps(int k, double factor) {
    X_.col(4) = rows_.v.col(j_) + factor * rows_.v.col(k);
    X_.col(3) = X_.col(4).array().sign().matrix();
    return jumps_with_motor(rows_, X_);
  }

 private:
  Rows rows_;
  int j_;
  Eigen::MatrixXd X_;
  Left own_;
};

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

/// The factor of a second motor that turns joint j with k, `Coupling::factor_of_second`.
double second_motor(Motors& of_joint, int k, double factor) {
  double best = 0, left = kHalf;
  const auto consider = [&](double second) {
    if (std::abs(second - factor) < kOne) return;
    if (const double now = of_joint.left_by_two(k, factor, second); now < left)
      left = now, best = second;
  };
  for (const double second : kFactors)
    for (const double sign : {1.0, -1.0}) consider(sign * second);
  consider(-factor);
  for (double step = kFirstStep; best != 0 && step > kLastStep; step = std::sqrt(step))
    for (double before = 0; before != best;) {
      before = best;
      consider(before * step);
      consider(before / step);
      if (const double size = std::abs(best); std::max(size, 1 / size) > kLargest) return 0;
    }
  return std::abs(std::abs(best) - 1) < kOne ? std::copysign(1, best) : best;
}

}  // namespace

std::vector<Coupling> find_couplings(std::span<const signals::Recording> recordings,
                                     const FrictionTorques& target) {
  const int n = recordings.front().n();
  std::vector<Coupling> found(static_cast<std::size_t>(n));
  for (int j = 0; j < n; ++j) {
    const double slides = kSlides * rms_speed(recordings, j);
    Motors all(rows_of(j, recordings, target, 0), j),
        sliding(rows_of(j, recordings, target, slides), j);
    if (!all.has_rows()) continue;
    Coupling& best = found[static_cast<std::size_t>(j)];
    best.r2 = all.r2();
    if (!all.leaves_any() || !sliding.has_rows() || !sliding.leaves_any()) continue;
    // at rest friction holds what any motion loads the joint with
    const auto consider = [&](int k, double factor) {
      double now = all.share(k, factor);
      if (now > best.share) now = std::min(now, sliding.share(k, factor));
      if (now > best.share) best = {k, factor, now, best.r2};
    };
    for (int k = std::max(0, j - kReach); k <= std::min(n - 1, j + kReach); ++k)
      for (const double factor : kFactors)
        for (const double sign : {1.0, -1.0})
          if (k != j) consider(k, sign * factor);
    if (best.with >= 0 && !refine(best, consider)) best = {.r2 = best.r2};
  }
  for (int j = 0; j < n; ++j) {
    Coupling& c = found[static_cast<std::size_t>(j)];
    if (c.with < 0) continue;
    Motors of_other(rows_of(c.with, recordings, target, 0), c.with);
    if (!of_other.has_rows() || !of_other.jumps(j, 1 / c.factor)) {
      c = {.r2 = c.r2};
      continue;
    }
    const auto [inner, outer] = std::minmax(j, c.with);
    Motors at_outer(rows_of(outer, recordings, target, 0), outer);
    const double of_outer = outer == j ? c.factor : 1 / c.factor;
    c.at_joint_too = at_outer.needs_own(inner, of_outer);
    if (const double second = c.at_joint_too ? second_motor(at_outer, inner, of_outer) : 0;
        second != 0) {
      c.at_joint_too = false;
      c.factor_of_second = outer == j ? second : 1 / second;
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

double declared_factor(const Coupling& coupling, int joint) {
  return -(joint > coupling.with ? coupling.factor : 1 / coupling.factor);
}

std::string declaration_of(const Coupling& coupling, int joint, const dynamics::RobotModel& robot) {
  const auto [outer, inner] = std::minmax(joint, coupling.with, std::greater());
  const bool is_declared = std::ranges::any_of(
      robot.couplings, [&, o = outer, i = inner](const dynamics::Coupling& of_robot) {
        return (of_robot.joint == o && of_robot.motor == i) ||
               (of_robot.joint == i && of_robot.motor == o);
      });
  if (is_declared || coupling.at_joint_too) return "";
  const auto table = [&](int of, int by, double factor) {
    return fmt::format("[[robot.coupling]] joint = \"{}\", motor = \"{}\", factor = {:.3g}",
                       robot.joints[static_cast<std::size_t>(of)].name,
                       robot.joints[static_cast<std::size_t>(by)].name, factor);
  };
  const double own = declared_factor(coupling, joint);
  if (coupling.factor_of_second == 0) return table(outer, inner, own);
  Coupling second = coupling;
  second.factor = coupling.factor_of_second;
  const double other = declared_factor(second, joint);
  return fmt::format("{} and {}", table(outer, inner, std::min(own, other)),
                     table(inner, outer, 1 / std::max(own, other)));
}

}  // namespace fricid::estimate
