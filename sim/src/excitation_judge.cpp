#include "excitation_judge.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "fricid/base/eigen_instances.hpp"
#include "fricid/base/error.hpp"
#include "fricid/base/not_finite.hpp"
#include "fricid/dynamics/base_parameters.hpp"
#include "fricid/system/transmission.hpp"

namespace fricid::sim {
namespace {

// Points per period of the fastest harmonic: in the search, and in the final check.
constexpr int kDesignDensity = 8, kCheckDensity = 80;

/// Allowance for friction as shares of effort: Coulomb, and viscous at the velocity limit. Upper
/// ends of values reported for geared industrial joints (Coulomb 5-8 %, viscous 15-30 %).
constexpr double kFrictionAtRest = 0.08, kFrictionAtSpeed = 0.3;

constexpr double kRounding = 1e-12;  // [rad or m] of a motion that touches the end of its box

double or_infinity(double share, double limit) { return limit > 0 ? share * limit : kInfinity; }

std::vector<Bounds> make_bounds(const ExcitationOptions& config,
                                const dynamics::RobotModel& robot) {
  std::vector<Bounds> bounds;
  for (std::size_t j = 0; j < robot.joints.size(); ++j) {
    const dynamics::Joint& joint = robot.joints[j];
    const bool limited = !joint.continuous && joint.upper > joint.lower;
    const auto [lower, upper] = dynamics::travel_of(joint);
    const double half = (upper - lower) / 2;
    Bounds b{config.centre.empty() ? lower + half : config.centre[j],
             config.half_range.empty() ? 0.9 * half : config.half_range[j],
             or_infinity(config.velocity_share, joint.velocity),
             or_infinity(config.acceleration_share, joint.acceleration),
             or_infinity(config.jerk_share, joint.jerk),
             or_infinity(config.torque_share, joint.effort)};
    if (limited && (b.centre - b.half < joint.lower || b.centre + b.half > joint.upper))
      throw UserError("excitation: {}: box [{:.3f}, {:.3f}] rad is outside [{:.3f}, {:.3f}]",
                      joint.name, b.centre - b.half, b.centre + b.half, joint.lower, joint.upper);
    bounds.push_back(b);
  }
  return bounds;
}

std::span<const double> column(const Eigen::MatrixXd& matrix, Eigen::Index k) {
  return {matrix.col(k).data(), static_cast<std::size_t>(matrix.rows())};
}

}  // namespace

ExcitationProblem::ExcitationProblem(const ExcitationOptions& c, const MujocoArm& m,
                                     const dynamics::RobotModel& r)
    : config(c),
      arm(m),
      robot(r),
      bounds(make_bounds(c, r)),
      columns(dynamics::base_parameters(r).columns),
      design(TimeGrid::over_period(c.base_rad_s, c.harmonics, kDesignDensity * c.harmonics)),
      check(TimeGrid::over_period(c.base_rad_s, c.harmonics, kCheckDensity * c.harmonics)) {}

ExcitationJudge::ExcitationJudge(const ExcitationProblem& problem)
    : problem_(problem),
      C_(Transmission(problem.robot).inverse()),
      ws_(problem.robot),
      // range of twice the required clearance, so that the search has a slope
      clearance_(problem.arm, 2 * (problem.config.clearance_m + kClearanceGuard) + 0.05),
      Y_(problem.robot.n(), problem.robot.parameter_count()),
      Y_base_(problem.robot.n(), static_cast<Eigen::Index>(problem.columns.size())) {}

Motion ExcitationJudge::at_motors(const Motion& motion) const {
  if (C_.size() == 0) return motion;
  Motion m = motion;
  for (auto* x : {&m.q, &m.v, &m.a}) *x = C_ * *x;
  return m;
}

Eigen::MatrixXd ExcitationJudge::information(const Motion& at_joints) {
  const Motion motion = at_motors(at_joints);
  const auto size = static_cast<Eigen::Index>(problem_.columns.size());
  Eigen::MatrixXd H = Eigen::MatrixXd::Zero(size, size);
  for (Eigen::Index k = 0; k < motion.q.cols(); ++k) {
    dynamics::regressor(problem_.robot, ws_, column(motion.q, k), column(motion.v, k),
                        column(motion.a, k), Y_);
    for (Eigen::Index c = 0; c < size; ++c)
      Y_base_.col(c) = Y_.col(problem_.columns[static_cast<std::size_t>(c)]);
    for (Eigen::Index j = 0; j < Y_base_.rows(); ++j) {
      const double effort = problem_.robot.joints[static_cast<std::size_t>(j)].effort;
      if (effort > 0) Y_base_.row(j) /= effort;
    }
    H.selfadjointView<Eigen::Lower>().rankUpdate(Y_base_.transpose());
  }
  H /= static_cast<double>(motion.q.cols());
  if (problem_.known.size() > 0) H += problem_.known;
  return H;
}

Eigen::VectorXd ExcitationJudge::torque_shares(const Motion& at_joints) {
  const Motion motion = at_motors(at_joints);
  const dynamics::RobotModel& robot = problem_.robot;
  Eigen::VectorXd shares = Eigen::VectorXd::Zero(robot.n());
  std::vector<double> tau(static_cast<std::size_t>(robot.n()));
  const std::span<const double> pi{robot.pi.data(), static_cast<std::size_t>(robot.pi.size())};
  for (Eigen::Index k = 0; k < motion.q.cols(); ++k) {
    dynamics::rnea<double>(robot, ws_, pi, column(motion.q, k), column(motion.v, k),
                           column(motion.a, k), tau);
    for (Eigen::Index j = 0; j < shares.size(); ++j) {
      const dynamics::Joint& joint = robot.joints[static_cast<std::size_t>(j)];
      if (joint.effort <= 0) continue;
      const double speed = joint.velocity > 0 ? std::abs(motion.v(j, k)) / joint.velocity : 0;
      const double share = std::abs(tau[static_cast<std::size_t>(j)]) / joint.effort +
                           kFrictionAtRest + kFrictionAtSpeed * speed;
      shares[j] = std::max(shares[j], share);
    }
  }
  return shares;
}

Clearance::Pair ExcitationJudge::closest(const Motion& motion, int stride) {
  Clearance::Pair best{kInfinity, -1, -1};
  for (Eigen::Index k = 0; k < motion.q.cols(); k += stride) {
    const Clearance::Pair pair = clearance_.closest(column(motion.q, k));
    if (pair.distance < best.distance) best = pair;
  }
  return best;
}

double log_det(const Eigen::MatrixXd& H) {
  const Eigen::VectorXd d = H.selfadjointView<Eigen::Lower>().ldlt().vectorD();
  return (d.array() > 0).all() ? d.array().log().sum() : -kInfinity;
}

double condition(const Eigen::MatrixXd& H) {
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(H, Eigen::EigenvaluesOnly);
  const Eigen::VectorXd& lambda = eigen.eigenvalues();
  return lambda[0] > 0 ? std::sqrt(lambda[lambda.size() - 1] / lambda[0]) : kInfinity;
}

double violation(const ExcitationProblem& problem, ExcitationJudge& judge, const Motion& motion,
                 int stride) {
  const Eigen::VectorXd shares = judge.torque_shares(motion);
  double sum = (shares.array() / problem.config.torque_share - (1 - kShareGuard)).max(0).sum();
  const double wanted = problem.config.clearance_m + kClearanceGuard;
  sum += std::max(0.0, (wanted - judge.closest(motion, stride).distance) / wanted);
  return sum;
}

TrajectoryReport examine_on(const ExcitationProblem& problem, ExcitationJudge& judge,
                            const Fourier& series, const TimeGrid& grid) {
  TrajectoryReport report;
  const Motion motion = grid.sample(series);
  const Eigen::VectorXd torque = judge.torque_shares(motion);
  const Eigen::MatrixXd H = judge.information(problem.design.sample(series));
  report.log_det = log_det(H);
  report.condition = condition(H);
  const Clearance::Pair pair = judge.closest(motion);
  report.clearance_m = pair.distance;
  report.closest = judge.clearance().name(pair);
  report.feasible = report.clearance_m >= problem.config.clearance_m;
  for (Eigen::Index j = 0; j < motion.q.rows(); ++j) {
    const Bounds& bounds = problem.bounds[static_cast<std::size_t>(j)];
    const auto left = [j](const Eigen::MatrixXd& m, double limit) {
      return 1 - m.row(j).cwiseAbs().maxCoeff() / limit;
    };
    const double reach = (motion.q.row(j).array() - bounds.centre).abs().maxCoeff();
    const JointMargins margins{problem.robot.joints[static_cast<std::size_t>(j)].name,
                               bounds.half - reach + kRounding,
                               left(motion.v, bounds.velocity),
                               left(motion.a, bounds.acceleration),
                               left(motion.jerk, bounds.jerk),
                               1 - torque[j] / problem.config.torque_share};
    report.joints.push_back(margins);
    report.feasible =
        report.feasible && std::min({margins.position_rad, margins.velocity, margins.acceleration,
                                     margins.jerk, margins.torque}) >= 0;
  }
  return report;
}

}  // namespace fricid::sim
