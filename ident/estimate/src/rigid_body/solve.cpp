#include "rigid_body/solve.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include <fmt/format.h>

#include "fricid/base/eigen_instances.hpp"
#include "fricid/dynamics/algorithms.hpp"
#include "fricid/dynamics/base_parameters.hpp"
#include "rigid_body/inertia_prior.hpp"
#include "rigid_body/information.hpp"
#include "rigid_body/reweight.hpp"
#include "rigid_body/unknowns.hpp"

namespace fricid::estimate {
namespace {

constexpr double kBlind = 10;  // times the jackknife's error, which is the larger one elsewhere
constexpr double kWorstCondition = 1e4;  // above it the base parameters are called ill conditioned
constexpr double kPossible = 10;         // times what the URDF gives the links: a size of errors
constexpr int kPoses = 20;               // per recording, of the inertia of a joint
constexpr Eigen::Index kRowsOfWellPosed = 10;  // else a joint may be fitted to the last digit

// Size of each unknown that makes 2 % of the rms torque of the joint that it matters most to.
Eigen::VectorXd sizes_that_matter(const Eigen::MatrixXd& shares) {
  constexpr double kShare = 0.02;
  const Eigen::ArrayXd largest = shares.colwise().maxCoeff().transpose();
  return (largest > 0).select(kShare / largest, 0.0).matrix();
}

// Size (p) that each standard parameter can have by the nominal inertia of its link, whatever the
// direction; infinite where that is zero, and for linear torques.
Eigen::VectorXd sizes_of_links(const dynamics::RobotModel& robot) {
  constexpr int kOfLink = 10, kMass = 0, kIxx = 4, kIyy = 6, kIzz = 9;
  Eigen::VectorXd size = Eigen::VectorXd::Zero(robot.parameter_count());
  for (int link = 0; link < robot.n(); ++link) {
    const auto pi = robot.pi.segment<kOfLink>(kOfLink * link);
    const double inertia = pi[kIxx] + pi[kIyy] + pi[kIzz];
    auto of_link = size.segment<kOfLink>(kOfLink * link);
    of_link.setConstant(inertia);
    of_link[kMass] = pi[kMass];
    of_link.segment<3>(kMass + 1).setConstant(std::sqrt(std::max(0.0, pi[kMass] * inertia)));
    const int armature = robot.armature_begin() + link;
    size[armature] = std::max(robot.pi[armature], inertia);
  }
  return (size.array() > 0).select(size.array(), std::numeric_limits<double>::infinity()).matrix();
}

// See `RigidBodyFit::base_size`.
// @param matters  sizes of all unknowns that matter
Eigen::VectorXd sizes_of_base(const dynamics::RobotModel& robot,
                              const dynamics::BaseParameters& base, const Eigen::VectorXd& value,
                              const Eigen::VectorXd& matters) {
  const Eigen::VectorXd of_links = sizes_of_links(robot);
  Eigen::VectorXd size(value.size());
  for (Eigen::Index i = 0; i < size.size(); ++i) {
    double possible = 0;
    for (int k = 0; k < robot.parameter_count(); ++k)
      if (base.K(i, k) != 0) possible += std::abs(base.K(i, k)) * of_links[k];
    const double here = matters[base.columns[static_cast<std::size_t>(i)]];
    size[i] = std::max(std::abs(value[i]), std::min(here, kPossible * possible));
  }
  return size;
}

/// Condition of the regression on the base parameters and friction alone, whatever the prior.
double condition_of(const Regression& data, std::vector<int> columns,
                    const std::vector<int>& friction, const Eigen::VectorXd& sigma) {
  columns.insert(columns.end(), friction.begin(), friction.end());
  Eigen::MatrixXd X = pick(data.rows, columns);
  for (Eigen::Index r = 0; r < X.rows(); ++r)
    X.row(r) /= sigma[data.joint[static_cast<std::size_t>(r)]];
  double condition = 0;
  invert(X.transpose() * X, &condition);
  return condition;
}

/// Joints without inertia, see `RigidBodyFit::without_inertia`, by a regression
/// tau = Y[columns] x + ... with the covariance of x.
std::vector<JointInertia> find_without_inertia(const dynamics::RobotModel& robot,
                                               std::span<const signals::Recording> sequences,
                                               const std::vector<int>& columns,
                                               const Eigen::VectorXd& x,
                                               const Eigen::MatrixXd& covariance) {
  const int n = robot.n();
  const auto of = [n](const Eigen::VectorXd& value) {
    return std::span<const double>(value.data(), static_cast<std::size_t>(n));
  };
  std::vector<JointInertia> largest;
  for (int j = 0; j < n; ++j) largest.push_back({j, -std::numeric_limits<double>::infinity(), 0});
  Eigen::VectorXd nominal = Eigen::VectorXd::Zero(n);  // in the same poses
  dynamics::Workspace<double> ws(robot);
  Eigen::MatrixXd moved(n, robot.parameter_count()), still = moved;
  const Eigen::VectorXd rest = Eigen::VectorXd::Zero(n);
  for (const signals::Recording& r : sequences)
    for (int k = 0; k < r.length(); k += std::max(1, r.length() / kPoses)) {
      const Eigen::VectorXd q = r.narrow.q.row(k).transpose();
      dynamics::regressor(robot, ws, of(q), of(rest), of(rest), still);
      for (int j = 0; j < n; ++j) {
        dynamics::regressor(robot, ws, of(q), of(rest), of(Eigen::VectorXd::Unit(n, j)), moved);
        const Eigen::RowVectorXd row = moved.row(j) - still.row(j);
        const Eigen::VectorXd y = pick(row, columns).transpose();
        JointInertia& found = largest[static_cast<std::size_t>(j)];
        if (const double value = y.dot(x); value > found.value) {
          found = {j, value, std::sqrt(std::max(0.0, y.dot(covariance * y)))};
          nominal[j] = row.dot(robot.pi);
        }
      }
    }
  // a joint that hardly moved says nothing; there the nominal value stays anyway
  std::erase_if(largest, [&](const JointInertia& found) {
    return found.value > found.error || found.value + found.error >= nominal[found.joint];
  });
  return largest;
}

/// Why there are fewer rows than unknowns, and what to do: missing values take rows away although
/// the arm moves.
std::string too_few_rows(Eigen::Index rows, Eigen::Index unknowns,
                         std::span<const signals::Recording> sequences) {
  Eigen::Index lacking = 0, all = 0;
  for (const signals::Recording& r : sequences) {
    all += r.length();
    for (Eigen::Index k = 0; k < r.length(); ++k)
      lacking += r.log.q.row(k).hasNaN() || r.log.tau.row(k).hasNaN();
  }
  std::string text =
      rows == 0 ? std::string("no sample of a joint that slides is left")
                : fmt::format("{} samples of joints that slide for {} unknowns", rows, unknowns);
  if (lacking == 0) return text + "; allowed: training data in which the arm moves";
  return text + fmt::format(
                    "; {} of {} samples lack a position or a torque, and the samples "
                    "around each take no part; log every channel at every sample",
                    lacking, all);
}

/// (n) Standard deviation of the residual without a prior; empty where there are too few rows.
Eigen::VectorXd sigma_alone(const Regression& data, const std::vector<int>& base,
                            const std::vector<int>& friction, int n, bool robust) {
  std::vector<int> columns = base;
  columns.insert(columns.end(), friction.begin(), friction.end());
  const auto size = std::ssize(columns);
  if (data.rows.rows() < kRowsOfWellPosed * size) return {};
  const Weighted alone = reweight(pick(data.rows, columns), data.tau, data.joint, n, robust,
                                  Eigen::MatrixXd::Zero(size, size), Eigen::VectorXd::Zero(size));
  return alone.x.allFinite() && alone.sigma.allFinite() ? alone.sigma : Eigen::VectorXd();
}

/// Minimises |G pi - d|^2 over physical parameters, pulled weakly to the nominal ones where G says
/// nothing. A link that carries what its file does not know is far from them: where they are off by
/// more than the pull allows, it grows as much weaker.
Eigen::VectorXd nearest_physical(const dynamics::RobotModel& robot, const Eigen::MatrixXd& G,
                                 const Eigen::VectorXd& d, const dynamics::Guesses& guesses) {
  constexpr int kPulls = 6;
  Eigen::MatrixXd pull = weak_pull(robot, guesses);
  Eigen::MatrixXd all(G.rows() + pull.rows(), G.cols());
  Eigen::VectorXd right(all.rows());
  Eigen::VectorXd pi = robot.pi;
  for (int i = 0; i < kPulls; ++i) {
    all << G, pull;
    right << d, pull * robot.pi;
    pi = fit_physical_inertia(robot, all, right, robot.pi);
    const Eigen::VectorXd off = pull * (pi - robot.pi);
    const double rms = off.norm() / std::sqrt(static_cast<double>(off.size()));
    if (!(rms > 1)) break;
    pull /= rms;
  }
  return pi;
}

}  // namespace

RigidBodyFit solve(const dynamics::RobotModel& robot, std::span<const signals::Recording> sequences,
                   const Regression& data, const NoiseRows& noise, const RigidBodyOptions& options,
                   RigidBodyFit fit) {
  const bool with_prior = has_prior(options);
  const int n = robot.n(), p = robot.parameter_count();
  const dynamics::BaseParameters base = dynamics::base_parameters(robot);
  const auto b = static_cast<Eigen::Index>(base.columns.size());
  const auto [columns, friction, prior_information, prior_mean, shares] =
      unknowns_of(robot, data, options);
  const auto f = std::ssize(friction), head = std::ssize(columns) - f;
  const Eigen::Index unknowns = with_prior ? f : b + f;
  if (data.rows.rows() <= unknowns) {
    fit.message = too_few_rows(data.rows.rows(), unknowns, sequences);
    fit.pi = robot.pi;
    return fit;
  }
  const auto prior_sd = [&](Eigen::Index k) { return 1 / std::sqrt(prior_information(k, k)); };
  fit.offset_prior_sd.setConstant(n, std::numeric_limits<double>::infinity());
  if (with_prior)
    for (std::size_t i = 0; i < robot.linear_torques.size(); ++i)
      if (const dynamics::LinearTorque& torque = robot.linear_torques[i];
          torque.shape == dynamics::LinearTorque::Shape::kConstant)
        fit.offset_prior_sd[torque.joint] =
            prior_sd(robot.linear_begin() + static_cast<Eigen::Index>(i));

  const Eigen::MatrixXd X = pick(data.rows, columns);
  if (options.prior.use)
    fit.sigma_alone = sigma_alone(data, base.columns, friction, n, options.robust);
  const Weighted solved = reweight(X, data.tau, data.joint, n, options.robust, prior_information,
                                   prior_mean, fit.sigma_alone);
  const Eigen::MatrixXd of_noise = noise_information(noise, columns, solved.weight);
  const Eigen::MatrixXd diluted = dilution_root(of_noise, solved.H, of_noise * solved.x);
  const Eigen::MatrixXd of_blocks =
      jackknife_root(X, data.tau, solved, data.passage, prior_information);
  const Eigen::MatrixXd inverse = invert(solved.H, nullptr);
  Eigen::MatrixXd of_held = Eigen::MatrixXd::Zero(X.cols(), std::ssize(options.held_armatures));
  if (with_prior) of_held = inverse.leftCols(p) * held_scores(robot, options);
  const Eigen::VectorXd of_timing = moved_by(data.late, X, solved, inverse);
  Eigen::MatrixXd errors_root(X.cols(), of_blocks.cols() + diluted.cols() + of_held.cols() + 1);
  errors_root << of_blocks, diluted, of_held, of_timing;
  const auto growing = std::ranges::count_if(friction, [&](int k) { return k >= p + 3 * n; });
  const auto certain = head + f - growing;  // without growth, which has a prior of its own
  invert(solved.H.topLeftCorner(certain, certain), &fit.condition);
  const Eigen::MatrixXd covariance = inverse + diluted * diluted.transpose();
  fit.sigma = solved.sigma;
  if (with_prior && !options.prior.use)
    fit.condition = condition_of(data, base.columns, friction, fit.sigma);
  if (options.prior_where_needed)  // else the caller knows them
    fit.without_inertia =
        find_without_inertia(robot, sequences, {columns.begin(), columns.begin() + head},
                             solved.x.head(head), covariance.topLeftCorner(head, head));

  // Base parameters and their uncertainty.
  const Eigen::MatrixXd to_base =
      with_prior ? base.K : Eigen::MatrixXd(Eigen::MatrixXd::Identity(b, b));
  fit.base_names = base.names;
  fit.base = to_base * solved.x.head(head);
  fit.base_se = (to_base * errors_root.topRows(head)).rowwise().norm();

  // no block of time moves what no block knows: the jackknife then has no error of it
  if (!with_prior)
    for (Eigen::Index k = 0; k < head; ++k)
      if (const double alone = std::sqrt(inverse(k, k)); !(alone < kBlind * fit.base_se[k]))
        fit.base_se[k] = alone;
  const Eigen::VectorXd sizes = sizes_that_matter(shares);
  fit.base_size = sizes_of_base(robot, base, fit.base, sizes);
  fit.friction_size = sizes.segment(p, 3 * n);

  // Linear friction.
  Eigen::VectorXd* const values[] = {&fit.Fc, &fit.Fv, &fit.offset, &fit.growth};
  Eigen::VectorXd* const errors[] = {&fit.Fc_se, &fit.Fv_se, &fit.offset_se, &fit.growth_se};
  const int kinds = growing > 0 ? 4 : 3;
  for (int kind = 0; kind < kinds; ++kind) {
    values[kind]->setZero(n);
    errors[kind]->setZero(n);
  }
  const Eigen::VectorXd friction_se = errors_root.bottomRows(f).rowwise().norm();
  for (Eigen::Index i = 0; i < f; ++i) {
    const int kind = (friction[static_cast<std::size_t>(i)] - p) / n;
    const int j = (friction[static_cast<std::size_t>(i)] - p) % n;
    (*values[kind])[j] = solved.x[head + i];
    (*errors[kind])[j] = friction_se[i];
  }

  // The physical parameters nearest to the estimate, friction marginalised.
  const Eigen::MatrixXd root = inverse_root(covariance.topLeftCorner(head, head));
  const Eigen::VectorXd found = root * solved.x.head(head);
  fit.pi = with_prior ? fit_physical_inertia(robot, root, found, robot.pi)
                      : nearest_physical(robot, root * base.K, found, options.guesses);
  fit.base_of_pi = base.K;
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

}  // namespace fricid::estimate
