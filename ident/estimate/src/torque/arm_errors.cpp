#include "fricid/estimate/torque/arm_errors.hpp"

#include <Eigen/Cholesky>
#include <cmath>
#include <limits>

#include "blocks.hpp"
#include "fricid/base/rng.hpp"
#include "rigid_body/dilution.hpp"
#include "rigid_body/inertia_prior.hpp"
#include "torque/arm_torque_problem.hpp"

namespace fricid::estimate {
namespace {

constexpr Eigen::Index kFewestBlocks = 10;
constexpr int kMostHalvings = 6;  // of a draw
constexpr std::uint64_t kDrawStream = 1 << 21;

/// The objective of the torque about a fitted arm.
struct AboutFit {
  AboutFit(const ArmTorqueData& data, const Arm& fitted, const ArmTorqueOptions& options,
           BodyCoordinates body, int jobs)
      : coordinates(fitted, options.coordinates),
        point(projected(ArmPoint(coordinates, fitted))),
        c(point.c()),
        problem(data, point, options, jobs, body),
        at(problem.linearise(c, std::numeric_limits<double>::quiet_NaN())),
        H(at.H),
        rows(problem.rows_at(c)) {
    // what the data leave open of pi the prior holds
    const Eigen::Index held = body == BodyCoordinates::kPi ? fitted.robot.pi.size() : 0;
    H.diagonal().head(H.rows() - held).array() += kStepRidge;
  }
  /// Onto what the coordinates can represent.
  static ArmPoint projected(ArmPoint point) {
    point.move_to(point.c());
    return point;
  }
  /// Root of the covariance of the jackknife (coordinates x blocks).
  Eigen::MatrixXd jackknife() const { return estimate::jackknife(problem.deletions(rows, H)); }

  ArmCoordinates coordinates;
  ArmPoint point;
  Eigen::VectorXd c;
  ArmTorqueProblem problem;
  optimise::Quadratic at;
  Eigen::MatrixXd H;  // of a step
  std::vector<ArmTorqueProblem::Rows> rows;
};

/// Coordinates of friction of which the data tell less than the ridge of a step, beside all others:
/// a jackknife hardly moves them. Each errs by the inverse root of what the data tell.
/// @param count       coordinates of friction, the first
/// @param covariance  inverse of the matrix of a step
/// @param by_c        (pi, theta) by coordinates
Eigen::MatrixXd root_of_open(Eigen::Index count, const Eigen::MatrixXd& covariance,
                             const Eigen::MatrixXd& by_c) {
  constexpr double kLeast = 1e-8;  // information
  std::vector<Eigen::Index> open;
  std::vector<double> errors;
  for (Eigen::Index i = 0; i < count; ++i) {
    const double information = 1 / covariance(i, i) - kStepRidge;
    if (!(information < kStepRidge)) continue;
    open.push_back(i);
    errors.push_back(1 / std::sqrt(std::max(kLeast, information)));
  }
  return by_c(Eigen::all, open) *
         Eigen::Map<const Eigen::VectorXd>(errors.data(), std::ssize(errors)).asDiagonal();
}

/// Root of the covariance of (pi, theta), see `ArmErrors`; its first columns are not of the motion.
/// A fit at the edge of what is physical errs as the data alone would.
ArmErrors errors_of(const ArmTorqueData& data, const MotionErrors& motion, const Arm& fitted,
                    const ArmTorqueOptions& options, int jobs) {
  const AboutFit fit(data, fitted, options, BodyCoordinates::kPi, jobs);
  const Eigen::MatrixXd moves = fit.jackknife();
  if (moves.cols() < kFewestBlocks) return {};
  const Eigen::LDLT<Eigen::MatrixXd> solver = fit.H.ldlt();
  const Eigen::MatrixXd of_motion = solver.solve(fit.problem.motion_scores(fit.rows, motion));
  const Eigen::VectorXd of_timing = solver.solve(fit.problem.timing_score(fit.rows));

  dynamics::RobotModel nominal = fitted.robot;
  nominal.pi = options.nominal;
  const Eigen::MatrixXd by_c = fit.problem.jacobian();
  const Eigen::MatrixXd of_pi = by_c.topRows(nominal.pi.size());
  const Eigen::MatrixXd of_held =
      solver.solve(of_pi.transpose() * held_scores(nominal, options.rigid_body));
  const Eigen::MatrixXd noise = fit.problem.noise_information();
  const Eigen::MatrixXd diluted =
      dilution_root(of_pi.transpose() * noise * of_pi, fit.H,
                    of_pi.transpose() * (noise * fit.point.arm().robot.pi));

  const Eigen::MatrixXd open =
      root_of_open(std::ssize(fit.coordinates.friction()),
                   solver.solve(Eigen::MatrixXd::Identity(fit.H.rows(), fit.H.cols())), by_c);

  const Eigen::Index before_motion =
      moves.cols() + of_held.cols() + diluted.cols() + open.cols() + 1;
  ArmErrors errors{.root = Eigen::MatrixXd(by_c.rows(), before_motion + of_motion.cols()),
                   .before_motion = before_motion,
                   .draws = {}};
  errors.root << by_c * moves, by_c * of_held, by_c * diluted, open, by_c * of_timing,
      by_c * of_motion;
  // of shares of a sum of one, whatever the data leave of the sum
  const std::vector<double> sums = friction::sums_of_shares(fitted.friction);
  for (const std::vector<std::size_t>& law : friction::shares(fitted.friction.model)) {
    const auto row_of = [&](std::size_t i) {
      return errors.root.row(fitted.robot.pi.size() + static_cast<Eigen::Index>(i));
    };
    Eigen::RowVectorXd of_sum = Eigen::RowVectorXd::Zero(errors.root.cols());
    for (const std::size_t i : law) of_sum += row_of(i);
    for (const std::size_t i : law) row_of(i) -= fitted.friction.theta[i] / sums[i] * of_sum;
  }
  return errors;
}

}  // namespace

TorquePull torque_pull(const ArmTorqueData& data, const MotionErrors& motion, const Arm& fitted,
                       const ArmTorqueOptions& options, int jobs) {
  AboutFit fit(data, fitted, options, BodyCoordinates::kPhysical, jobs);
  // (H^-1 + M M')^-1 = H - S (1 + S'M)^-1 S', M = H^-1 S
  const Eigen::MatrixXd S = fit.problem.motion_scores(fit.rows, motion);
  Eigen::MatrixXd within = S.transpose() * fit.H.ldlt().solve(S);
  within.diagonal().array() += 1;
  fit.at.H -= S * within.ldlt().solve(S.transpose());
  return {fit.c, std::move(fit.at)};
}

ArmErrors arm_errors(const ArmTorqueData& data, const MotionErrors& motion, const Arm& fitted,
                     const ArmTorqueOptions& options, int count, std::uint64_t seed, int jobs) {
  ArmErrors errors = errors_of(data, motion, fitted, options, jobs);
  if (errors.root.size() == 0 || count == 0) return errors;
  AboutFit fit(data, fitted, options, BodyCoordinates::kPhysical, jobs);
  auto& [coordinates, point, c, problem, at, H, rows] = fit;
  const Eigen::MatrixXd moves = fit.jackknife();
  RowMatrix w(count, moves.cols());
  fill_normal(seed, kDrawStream, 0, {w.data(), static_cast<std::size_t>(w.size())});
  const double least = problem.value(c);
  for (Eigen::Index i = 0; i < count; ++i) {
    Eigen::VectorXd move = moves * w.row(i).transpose();
    const auto is_quadratic = [&] {
      const double rise = problem.value(coordinates.box().clamp(c + move)) - least;
      return rise - at.g.dot(move) < move.dot(at.H * move);
    };
    for (int half = 0; half < kMostHalvings && !is_quadratic(); ++half) move /= 2;
    point.move_to(coordinates.box().clamp(c + move));
    errors.draws.push_back(point.arm());
  }
  return errors;
}

}  // namespace fricid::estimate
