#include "fricid/estimate/torque/arm_errors.hpp"

#include <Eigen/Cholesky>
#include <cmath>
#include <limits>

#include "fricid/base/rng.hpp"
#include "rigid_body/dilution.hpp"
#include "rigid_body/inertia_prior.hpp"
#include "torque/arm_torque_problem.hpp"

namespace fricid::estimate {
namespace {

constexpr double kFewestBlocks = 10;
constexpr int kMostHalvings = 6;  // of a draw
constexpr std::uint64_t kDrawStream = 1 << 21;

/// The objective of the torque about a fitted arm.
struct AboutFit {
  AboutFit(const ArmTorqueData& data, const Arm& fitted, const ArmTorqueOptions& options, int jobs)
      : coordinates(fitted, options.coordinates),
        point(projected(ArmPoint(coordinates, fitted))),
        c(point.c()),
        problem(data, point, options, jobs),
        at(problem.linearise(c, std::numeric_limits<double>::quiet_NaN())),
        H(at.H),
        rows(problem.rows_at(c)) {
    H.diagonal().array() += kStepRidge;
  }
  /// Onto what the coordinates can represent.
  static ArmPoint projected(ArmPoint point) {
    point.move_to(point.c());
    return point;
  }

  ArmCoordinates coordinates;
  ArmPoint point;
  Eigen::VectorXd c;
  ArmTorqueProblem problem;
  optimise::Quadratic at;
  Eigen::MatrixXd H;  // of a step
  std::vector<ArmTorqueProblem::Rows> rows;
};

}  // namespace

TorquePull torque_pull(const ArmTorqueData& data, const MotionErrors& motion, const Arm& fitted,
                       const ArmTorqueOptions& options, int jobs) {
  AboutFit fit(data, fitted, options, jobs);
  // (H^-1 + M M')^-1 = H - S (1 + S'M)^-1 S', M = H^-1 S
  const Eigen::MatrixXd S = fit.problem.motion_scores(fit.rows, motion);
  Eigen::MatrixXd within = S.transpose() * fit.H.ldlt().solve(S);
  within.diagonal().array() += 1;
  fit.at.H -= S * within.ldlt().solve(S.transpose());
  return {fit.c, std::move(fit.at)};
}

ArmErrors arm_errors(const ArmTorqueData& data, const MotionErrors& motion, const Arm& fitted,
                     const ArmTorqueOptions& options, int count, std::uint64_t seed, int jobs) {
  AboutFit fit(data, fitted, options, jobs);
  auto& [coordinates, point, c, problem, at, H, rows] = fit;
  Eigen::MatrixXd moves = problem.deletions(rows, H);
  const auto blocks = static_cast<double>(moves.cols());
  if (blocks < kFewestBlocks) return {};
  moves.colwise() -= moves.rowwise().mean().eval();
  moves *= std::sqrt((blocks - 1) / blocks);
  RowMatrix w(count, moves.cols());
  fill_normal(seed, kDrawStream, 0, {w.data(), static_cast<std::size_t>(w.size())});
  const double least = problem.value(c);
  const Eigen::MatrixXd of_motion = H.ldlt().solve(problem.motion_scores(rows, motion));
  const Eigen::MatrixXd by_c = point.jacobian();
  dynamics::RobotModel nominal = fitted.robot;
  nominal.pi = options.nominal;
  const Eigen::MatrixXd of_held = H.ldlt().solve(by_c.topRows(nominal.pi.size()).transpose() *
                                                 held_scores(nominal, options.rigid_body));
  const Eigen::MatrixXd of_pi = by_c.topRows(nominal.pi.size());
  const Eigen::MatrixXd noise = problem.noise_information();
  const Eigen::MatrixXd diluted = dilution_root(of_pi.transpose() * noise * of_pi, H,
                                                of_pi.transpose() * (noise * fitted.robot.pi));
  const Eigen::Index before_motion = moves.cols() + of_held.cols() + diluted.cols();
  ArmErrors errors{.root = Eigen::MatrixXd(by_c.rows(), before_motion + of_motion.cols()),
                   .before_motion = before_motion,
                   .draws = {}};
  errors.root << by_c * moves, by_c * of_held, by_c * diluted, by_c * of_motion;
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
  for (Eigen::Index i = 0; i < count; ++i) {
    Eigen::VectorXd move = moves * w.row(i).transpose();
    const auto is_quadratic = [&] {
      const double rise = problem.value(coordinates.box().clamp(c + move)) - least;
      return rise - 2 * at.g.dot(move) < 2 * move.dot(at.H * move);
    };
    for (int half = 0; half < kMostHalvings && !is_quadratic(); ++half) move /= 2;
    point.move_to(coordinates.box().clamp(c + move));
    errors.draws.push_back(point.arm());
  }
  return errors;
}

}  // namespace fricid::estimate
