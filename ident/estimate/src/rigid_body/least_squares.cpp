#include "fricid/estimate/rigid_body/least_squares.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "fricid/base/eigen_instances.hpp"
#include "fricid/base/unit_of_joint.hpp"
#include "fricid/dynamics/algorithms.hpp"
#include "fricid/dynamics/base_parameters.hpp"
#include "rigid_body/inertia_prior.hpp"
#include "rigid_body/information.hpp"
#include "rigid_body/regression.hpp"
#include "rigid_body/reweight.hpp"

namespace fricid::estimate {
namespace {

constexpr double kWorstCondition = 1e4;  // above it the base parameters are called ill conditioned
constexpr double kLeastUsual = 1. / 3;   // of a guessed armature: some gears have as little
constexpr double kOffset = 0.1;          // sd of an offset over the torque's rms, under a prior
constexpr int kPoses = 20;               // per recording, of the inertia of a joint

// Columns of `full` listed in `columns`.
Eigen::MatrixXd pick(const Eigen::MatrixXd& full, const std::vector<int>& columns) {
  Eigen::MatrixXd out(full.rows(), static_cast<Eigen::Index>(columns.size()));
  for (std::size_t i = 0; i < columns.size(); ++i)
    out.col(static_cast<Eigen::Index>(i)) = full.col(columns[i]);
  return out;
}

// Share (n x columns) of the rms torque of each joint that a unit of each unknown makes.
Eigen::MatrixXd shares_of_torque(const Regression& data, int n) {
  Eigen::VectorXd torque = Eigen::VectorXd::Zero(n);
  Eigen::MatrixXd columns = Eigen::MatrixXd::Zero(n, data.rows.cols());
  for (Eigen::Index r = 0; r < data.rows.rows(); ++r) {
    const int j = data.joint[static_cast<std::size_t>(r)];
    torque[j] += data.tau[r] * data.tau[r];
    columns.row(j) += data.rows.row(r).cwiseAbs2();
  }
  for (int j = 0; j < n; ++j) columns.row(j) *= torque[j] > 0 ? 1 / torque[j] : 0;
  return columns.cwiseSqrt();
}

// Size of each unknown that makes 2 % of the rms torque of the joint that it matters most to.
Eigen::VectorXd sizes_that_matter(const Eigen::MatrixXd& shares) {
  constexpr double kShare = 0.02;
  const Eigen::ArrayXd largest = shares.colwise().maxCoeff().transpose();
  return (largest > 0).select(kShare / largest, 0.0).matrix();
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

/// Precision (p + columns of friction) of linear friction and offsets under a prior. In a log whose
/// joints slide in one direction the sum of Coulomb friction and offset is known, not its parts:
/// the offset is small, friction within the torque. Offsets with a stated width keep it.
/// @param shares  see `shares_of_torque`
Eigen::VectorXd precision_of_friction(const dynamics::RobotModel& robot,
                                      const Eigen::MatrixXd& shares,
                                      const std::vector<int>& friction,
                                      const std::vector<double>& stated_sd) {
  const int n = robot.n(), p = robot.parameter_count();
  const auto precision_of = [&](int j, int column, double share) {
    return std::pow(shares(j, column) / share, 2);
  };
  Eigen::VectorXd precision = Eigen::VectorXd::Zero(p + std::ssize(friction));
  for (std::size_t i = 0; i < robot.linear_torques.size(); ++i)
    if (robot.linear_torques[i].shape == dynamics::LinearTorque::Shape::kConstant &&
        (i >= stated_sd.size() || !std::isfinite(stated_sd[i]))) {
      const int column = robot.linear_begin() + static_cast<int>(i);
      precision[column] = precision_of(robot.linear_torques[i].joint, column, kOffset);
    }
  for (std::size_t i = 0; i < friction.size(); ++i) {
    const int kind = (friction[i] - p) / n, j = (friction[i] - p) % n;
    if (kind != 1)
      precision[p + static_cast<Eigen::Index>(i)] =
          precision_of(j, friction[i], kind == 2 ? kOffset : 1);
  }
  return precision;
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

// What takes rows away although the arm moves; empty where nothing is missing.
std::string missing_values(std::span<const signals::Recording> sequences) {
  Eigen::Index lacking = 0, all = 0;
  for (const signals::Recording& r : sequences) {
    all += r.length();
    for (Eigen::Index k = 0; k < r.length(); ++k)
      lacking += r.log.q.row(k).hasNaN() || r.log.tau.row(k).hasNaN();
  }
  if (lacking == 0) return {};
  return fmt::format(
      "; {} of {} samples lack a position or a torque, and the samples around each take no part",
      lacking, all);
}

/// Solves the regression; `fit` holds its counts.
RigidBodyFit solve(const dynamics::RobotModel& robot, std::span<const signals::Recording> sequences,
                   const Regression& data, const RigidBodyOptions& options, RigidBodyFit fit) {
  const bool with_prior = has_prior(options);
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
    fit.message = fmt::format("{} rows of sliding joints for {} unknowns{}", data.rows.rows(),
                              unknowns, missing_values(sequences));
    fit.pi = robot.pi;
    return fit;
  }

  Eigen::MatrixXd prior_information = Eigen::MatrixXd::Zero(head + f, head + f);
  Eigen::VectorXd prior_mean = Eigen::VectorXd::Zero(head + f);
  const Eigen::MatrixXd shares = shares_of_torque(data, n);
  if (with_prior) {
    prior_information.topLeftCorner(p, p) = prior_precision(robot, options);
    prior_mean.head(p) = robot.pi;
    prior_information.diagonal() +=
        precision_of_friction(robot, shares, friction, options.linear_prior_sd);
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
  const Weighted solved =
      reweight(X, data.tau, data.joint, n, options.robust, prior_information, prior_mean);
  const Eigen::MatrixXd jackknife =
      jackknife_root(X, data.tau, solved, data.block, prior_information);
  const Eigen::MatrixXd covariance = invert(solved.H, &fit.condition);
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
  fit.base_se = (to_base * jackknife.topRows(head)).rowwise().norm();

  const Eigen::VectorXd sizes = sizes_that_matter(shares);
  fit.base_size.resize(b);
  for (Eigen::Index i = 0; i < b; ++i)
    fit.base_size[i] =
        std::max(std::abs(fit.base[i]), sizes[base.columns[static_cast<std::size_t>(i)]]);
  fit.friction_size = sizes.tail(3 * n);

  // Linear friction.
  for (auto* vector : {&fit.Fc, &fit.Fv, &fit.offset, &fit.Fc_se, &fit.Fv_se, &fit.offset_se})
    vector->setZero(n);
  const Eigen::VectorXd friction_se = jackknife.bottomRows(f).rowwise().norm();
  for (Eigen::Index i = 0; i < f; ++i) {
    const int kind = (friction[static_cast<std::size_t>(i)] - p) / n;
    const int j = (friction[static_cast<std::size_t>(i)] - p) % n;
    auto& value = kind == 0 ? fit.Fc : kind == 1 ? fit.Fv : fit.offset;
    auto& se = kind == 0 ? fit.Fc_se : kind == 1 ? fit.Fv_se : fit.offset_se;
    value[j] = solved.x[head + i];
    se[j] = friction_se[i];
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

/// See `RigidBodyFit::slower`. The usual speed is lowered as a matter of course.
std::string slower_than_asked(const dynamics::RobotModel& robot, const RigidBodyOptions& options,
                              const std::vector<double>& least_speed) {
  if (options.min_speed_rad_s == RigidBodyOptions{}.min_speed_rad_s) return {};
  std::vector<std::string> slower;
  for (std::size_t j = 0; j < least_speed.size(); ++j)
    if (const dynamics::Joint& joint = robot.joints[j]; least_speed[j] < options.min_speed_rad_s)
      slower.push_back(fmt::format("{:.2g} {} of {}", least_speed[j],
                                   unit_of_joint("rad/s", slides(joint)), joint.name));
  if (slower.empty()) return {};
  return fmt::format("min_speed_rad_s = {:.3g} is too fast for the motion: rows enter from {}",
                     options.min_speed_rad_s, fmt::join(slower, ", "));
}

}  // namespace

bool RigidBodyFit::moves_at_one_speed(int joint) const {
  const auto at = static_cast<std::size_t>(joint);
  return at < speeds.size() && speeds[at].is_one();
}

RigidBodyOptions as_needed(RigidBodyOptions options, const RigidBodyFit& fit) {
  options.prior.use = !fit.prior.empty();
  for (const JointInertia& joint : fit.without_inertia)
    options.held_armatures.push_back(joint.joint);
  options.prior_where_needed = false;
  return options;
}

RigidBodyFit rigid_body_least_squares(const dynamics::RobotModel& robot,
                                      std::span<const signals::Recording> sequences,
                                      const RigidBodyOptions& options,
                                      const FrictionTorques* shape) {
  const auto begin = std::chrono::steady_clock::now();
  RigidBodyFit counts;
  const Regression data = stack(robot, sequences, options, shape, counts);
  RigidBodyOptions used = options;
  RigidBodyFit fit = solve(robot, sequences, data, used, counts);
  std::string why = options.prior.use ? "asked for" : "";
  if (options.prior_where_needed && !options.prior.use) {
    why = undetermined(fit);
    used.prior.use = !why.empty();
    if (used.prior.use) fit = solve(robot, sequences, data, used, counts);
  }
  if (const std::vector<JointInertia> without = fit.without_inertia;
      options.prior_where_needed && !without.empty()) {
    dynamics::RobotModel held = robot;
    for (const JointInertia& joint : without) {
      used.held_armatures.push_back(joint.joint);
      if (std::ranges::count(options.guesses.armature, joint.joint) > 0)
        held.pi[held.armature_begin() + joint.joint] *= kLeastUsual;
    }
    fit = solve(held, sequences, data, used, counts);
    fit.without_inertia = without;
  }
  fit.prior = why;
  fit.slower = slower_than_asked(robot, options, fit.least_speed);
  fit.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  return fit;
}

}  // namespace fricid::estimate
