#include "fricid/estimate/rigid_body/least_squares.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>

#include <fmt/format.h>

#include "fricid/base/eigen_instances.hpp"
#include "fricid/dynamics/algorithms.hpp"
#include "fricid/dynamics/base_parameters.hpp"
#include "rigid_body/inertia_prior.hpp"
#include "rigid_body/information.hpp"
#include "rigid_body/regression.hpp"
#include "rigid_body/reweight.hpp"

namespace fricid::estimate {
namespace {

constexpr double kWorstCondition = 1e4;  // above it the base parameters are called ill conditioned

// Columns of `full` listed in `columns`.
Eigen::MatrixXd pick(const Eigen::MatrixXd& full, const std::vector<int>& columns) {
  Eigen::MatrixXd out(full.rows(), static_cast<Eigen::Index>(columns.size()));
  for (std::size_t i = 0; i < columns.size(); ++i)
    out.col(static_cast<Eigen::Index>(i)) = full.col(columns[i]);
  return out;
}

// Size of the unknown of each column of the regression that makes `share` of the rms torque of the
// joint that it matters most to.
Eigen::VectorXd sizes_that_matter(const Regression& data, int n) {
  constexpr double kShare = 0.02;
  Eigen::VectorXd torque = Eigen::VectorXd::Zero(n);
  Eigen::MatrixXd columns = Eigen::MatrixXd::Zero(n, data.rows.cols());
  for (Eigen::Index r = 0; r < data.rows.rows(); ++r) {
    const int j = data.joint[static_cast<std::size_t>(r)];
    torque[j] += data.tau[r] * data.tau[r];
    columns.row(j) += data.rows.row(r).cwiseAbs2();
  }
  Eigen::VectorXd sizes(data.rows.cols());
  for (Eigen::Index c = 0; c < sizes.size(); ++c) {
    double share = 0;  // largest of a unit of this unknown
    for (int j = 0; j < n; ++j)
      if (torque[j] > 0) share = std::max(share, std::sqrt(columns(j, c) / torque[j]));
    sizes[c] = share > 0 ? kShare / share : 0;
  }
  return sizes;
}

}  // namespace

RowMatrix rigid_body_torque(const dynamics::RobotModel& robot, const Eigen::VectorXd& pi,
                            const signals::Recording& sequence) {
  const auto n = static_cast<std::size_t>(robot.n());
  dynamics::Workspace<double> ws(robot);
  RowMatrix tau(sequence.length(), sequence.n());
  for (int k = 0; k < sequence.length(); ++k) {
    const auto row = [&](const RowMatrix& x) {
      return std::span<const double>(x.row(k).data(), n);
    };
    dynamics::rnea<double>(robot, ws, {pi.data(), static_cast<std::size_t>(pi.size())},
                           row(sequence.narrow.q), row(sequence.narrow.v), row(sequence.narrow.a),
                           {tau.row(k).data(), n});
  }
  return tau;
}

namespace {

/// Solves the regression; `fit` holds its counts.
RigidBodyFit solve(const dynamics::RobotModel& robot, const Regression& data,
                   const RigidBodyOptions& options, bool with_prior, RigidBodyFit fit) {
  const int n = robot.n(), p = robot.parameter_count();
  const dynamics::BaseParameters base = dynamics::base_parameters(robot);
  const auto b = static_cast<Eigen::Index>(base.columns.size());

  // Friction columns that any row excites.
  std::vector<int> friction;
  for (int k = p; k < p + 3 * n; ++k)
    if (data.rows.col(k).squaredNorm() > 0) friction.push_back(k);
  const auto f = static_cast<Eigen::Index>(friction.size());

  // Unknowns: base parameters, or all standard parameters under a prior; then friction.
  std::vector<int> columns;
  if (with_prior)
    for (int k = 0; k < p; ++k) columns.push_back(k);
  else
    columns = base.columns;
  const auto head = static_cast<Eigen::Index>(columns.size());
  columns.insert(columns.end(), friction.begin(), friction.end());
  const Eigen::Index unknowns = with_prior ? f : b + f;
  if (data.rows.rows() <= unknowns) {
    fit.message =
        fmt::format("{} rows of sliding joints for {} unknowns", data.rows.rows(), unknowns);
    fit.pi = robot.pi;
    return fit;
  }

  Eigen::MatrixXd prior_information = Eigen::MatrixXd::Zero(head + f, head + f);
  Eigen::VectorXd prior_mean = Eigen::VectorXd::Zero(head + f);
  if (with_prior) {
    prior_information.topLeftCorner(p, p) = prior_precision(robot, options);
    prior_mean.head(p) = robot.pi;
  }

  const Weighted solved = reweight(pick(data.rows, columns), data.tau, data.joint, n,
                                   options.robust, prior_information, prior_mean);
  const Eigen::MatrixXd covariance = invert(solved.H, &fit.condition);
  fit.sigma = solved.sigma;

  // Base parameters and their uncertainty.
  const Eigen::MatrixXd to_base =
      with_prior ? base.K : Eigen::MatrixXd(Eigen::MatrixXd::Identity(b, b));
  fit.base_names = base.names;
  fit.base = to_base * solved.x.head(head);
  fit.base_se = (to_base * covariance.topLeftCorner(head, head) * to_base.transpose())
                    .diagonal()
                    .cwiseMax(0)
                    .cwiseSqrt();

  const Eigen::VectorXd sizes = sizes_that_matter(data, n);
  fit.base_size.resize(b);
  for (Eigen::Index i = 0; i < b; ++i)
    fit.base_size[i] =
        std::max(std::abs(fit.base[i]), sizes[base.columns[static_cast<std::size_t>(i)]]);
  fit.friction_size = sizes.tail(3 * n);

  // Linear friction.
  for (auto* vector : {&fit.Fc, &fit.Fv, &fit.offset, &fit.Fc_se, &fit.Fv_se, &fit.offset_se})
    vector->setZero(n);
  for (Eigen::Index i = 0; i < f; ++i) {
    const int kind = (friction[static_cast<std::size_t>(i)] - p) / n;
    const int j = (friction[static_cast<std::size_t>(i)] - p) % n;
    auto& value = kind == 0 ? fit.Fc : kind == 1 ? fit.Fv : fit.offset;
    auto& se = kind == 0 ? fit.Fc_se : kind == 1 ? fit.Fv_se : fit.offset_se;
    value[j] = solved.x[head + i];
    se[j] = std::sqrt(std::max(0.0, covariance(head + i, head + i)));
  }

  // The physical parameters nearest to the estimate, friction marginalised.
  const Eigen::MatrixXd root = inverse_root(covariance.topLeftCorner(head, head));
  Eigen::MatrixXd G = root;
  Eigen::VectorXd d = root * solved.x.head(head);
  if (!with_prior) {
    const Eigen::MatrixXd pull = weak_pull(robot, options.guesses);
    G.resize(head + p, p);
    G << root * base.K, pull;
    d.resize(head + p);
    d << root * solved.x.head(head), pull * robot.pi;
  }
  fit.pi = fit_physical_inertia(robot, G, d, robot.pi);
  fit.base_physical = base.K * fit.pi;

  // friction given these: the minimum over it of the same quadratic
  const Eigen::VectorXd moved = (with_prior ? fit.pi : fit.base_physical) - solved.x.head(head);
  const Eigen::VectorXd beside =
      solved.x.tail(f) - invert(solved.H.bottomRightCorner(f, f), nullptr) *
                             (solved.H.bottomLeftCorner(f, head) * moved);
  fit.Fc_beside = fit.Fc;
  fit.Fv_beside = fit.Fv;
  for (Eigen::Index i = 0; i < f; ++i) {
    const int kind = (friction[static_cast<std::size_t>(i)] - p) / n;
    const int j = (friction[static_cast<std::size_t>(i)] - p) % n;
    if (kind == 0) fit.Fc_beside[j] = beside[i];
    if (kind == 1) fit.Fv_beside[j] = beside[i];
  }

  const bool finite = fit.pi.allFinite() && fit.base.allFinite();
  fit.outcome = !finite                           ? Outcome::kFailed
                : fit.condition > kWorstCondition ? Outcome::kIllConditioned
                                                  : Outcome::kConverged;
  fit.message =
      !finite ? "no finite solution"
              : fmt::format("condition {:.3g}, {} equations", fit.condition, data.rows.rows());
  return fit;
}

/// Why the data alone do not determine the base parameters; empty when they do.
std::string undetermined(const RigidBodyFit& fit) {
  if (fit.outcome == Outcome::kConverged) return {};
  return fit.outcome == Outcome::kIllConditioned
             ? fmt::format("condition {:.3g} without it", fit.condition)
             : fit.message;
}

}  // namespace

RigidBodyFit rigid_body_least_squares(const dynamics::RobotModel& robot,
                                      std::span<const signals::Recording> sequences,
                                      const RigidBodyOptions& options,
                                      const FrictionTorques* shape) {
  const auto begin = std::chrono::steady_clock::now();
  RigidBodyFit counts;
  const Regression data = stack(robot, sequences, options, shape, counts);
  RigidBodyFit fit = solve(robot, data, options, options.prior.use, counts);
  if (options.prior.use)
    fit.prior = "asked for";
  else if (const std::string why = undetermined(fit); options.prior_where_needed && !why.empty()) {
    fit = solve(robot, data, options, true, counts);
    fit.prior = why;
  }
  fit.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  return fit;
}

}  // namespace fricid::estimate
