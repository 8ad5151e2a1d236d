#include "fricid/estimate/rigid_body/least_squares.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "fricid/base/eigen_instances.hpp"
#include "fricid/base/unit_of_joint.hpp"
#include "fricid/data/fit_file.hpp"
#include "fricid/dynamics/algorithms.hpp"
#include "fricid/dynamics/base_parameters.hpp"
#include "rigid_body/dilution.hpp"
#include "rigid_body/inertia_prior.hpp"
#include "rigid_body/information.hpp"
#include "rigid_body/regression.hpp"
#include "rigid_body/reweight.hpp"

namespace fricid::estimate {
namespace {

constexpr double kWorstCondition = 1e4;  // above it the base parameters are called ill conditioned
constexpr double kLeastUsual = 1. / 3;   // of a guessed armature: some gears have as little
constexpr double kOffset = 0.1;          // sd of an offset over the torque's rms, under a prior
constexpr double kPossible = 10;         // times what the URDF gives the links: a size of errors
constexpr int kPoses = 20;               // per recording, of the inertia of a joint
constexpr int kLoadPasses = 8;           // of friction that grows with the torque of the last pass
constexpr double kStillGrowth = 1e-4;    // change of that growth
constexpr double kLeastGrowth = 0.01;    // that is shown, ..
constexpr double kGrowthErrors = 6;      // .. in standard errors, ..
constexpr double kGrowthGain = 1.2;      // .. in log of the variance that it explains of its joint

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
/// the offset is small, friction within the torque. Offsets with a stated width keep it. Growth of
/// friction has its own prior.
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
    if (kind == 0 || kind == 2)
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

/// What a regression solves for: base parameters, or all standard parameters under a prior; then
/// the friction that any row excites, growth with the load last.
struct Unknowns {
  std::vector<int> columns, friction;  ///< of the regression; friction is the end of columns
  Eigen::MatrixXd prior_information;
  Eigen::VectorXd prior_mean;
  Eigen::MatrixXd shares;  ///< see `shares_of_torque`

  Eigen::Index head() const { return std::ssize(columns) - std::ssize(friction); }
};

Unknowns unknowns_of(const dynamics::RobotModel& robot, const Regression& data,
                     const RigidBodyOptions& options) {
  const int n = robot.n(), p = robot.parameter_count();
  const bool with_prior = has_prior(options);
  Unknowns out;
  if (with_prior)
    for (int k = 0; k < p; ++k) out.columns.push_back(k);
  else
    out.columns = dynamics::base_parameters(robot).columns;
  out.friction = excited_friction(robot, data);
  out.columns.insert(out.columns.end(), out.friction.begin(), out.friction.end());
  const auto size = std::ssize(out.columns);
  out.prior_information = Eigen::MatrixXd::Zero(size, size);
  out.prior_mean = Eigen::VectorXd::Zero(size);
  out.shares = shares_of_torque(data, n);
  if (with_prior) {
    out.prior_information.topLeftCorner(p, p) = prior_precision(robot, options);
    out.prior_mean.head(p) = robot.pi;
    out.prior_information.diagonal() +=
        precision_of_friction(robot, out.shares, out.friction, options.linear_prior_sd);
  }
  for (Eigen::Index k = out.head(); k < size; ++k)
    if (out.columns[static_cast<std::size_t>(k)] >= p + 3 * n)
      out.prior_information(k, k) = std::pow(kUsualGrowth, -2);
  return out;
}

constexpr Eigen::Index kRowsOfWellPosed = 10;  // else a joint may be fitted to the last digit

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

/// Solves the regression; `fit` holds its counts.
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
    fit.message = fmt::format("{} rows of sliding joints for {} unknowns{}", data.rows.rows(),
                              unknowns, missing_values(sequences));
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
      jackknife_root(X, data.tau, solved, data.block, prior_information);
  Eigen::MatrixXd of_held = Eigen::MatrixXd::Zero(X.cols(), std::ssize(options.held_armatures));
  if (with_prior) of_held = invert(solved.H, nullptr).leftCols(p) * held_scores(robot, options);
  Eigen::MatrixXd errors_root(X.cols(), of_blocks.cols() + diluted.cols() + of_held.cols());
  errors_root << of_blocks, diluted, of_held;
  const auto growing = std::ranges::count_if(friction, [&](int k) { return k >= p + 3 * n; });
  const auto certain = head + f - growing;  // without growth, which has a prior of its own
  invert(solved.H.topLeftCorner(certain, certain), &fit.condition);
  const Eigen::MatrixXd covariance = invert(solved.H, nullptr) + diluted * diluted.transpose();
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

  const Eigen::VectorXd sizes = sizes_that_matter(shares);
  fit.base_size.resize(b);
  const Eigen::VectorXd of_links = sizes_of_links(robot);
  for (Eigen::Index i = 0; i < b; ++i) {
    double possible = 0;
    for (int k = 0; k < p; ++k)
      if (base.K(i, k) != 0) possible += std::abs(base.K(i, k)) * of_links[k];
    const double matters = sizes[base.columns[static_cast<std::size_t>(i)]];
    fit.base_size[i] = std::max(std::abs(fit.base[i]), std::min(matters, kPossible * possible));
  }
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

/// Rows with columns (n) of friction that grows with the load, all zero: no joint has any yet.
Regression with_room_for_growth(Regression data, int n) {
  data.rows.conservativeResize(Eigen::NoChange, data.rows.cols() + n);
  data.rows.rightCols(n).setZero();
  return data;
}

/// Sets the columns of growth of the joints, F[sign v_j] |load_j|.
/// @param load  (N) of the rows
void set_growth(const std::vector<int>& joints, int n, const Eigen::VectorXd& load,
                Regression& data) {
  const Eigen::Index growth = data.rows.cols() - n, coulomb = growth - 3 * n;
  data.rows.rightCols(n).setZero();
  for (Eigen::Index r = 0; r < load.size(); ++r)
    if (const int j = data.joint[static_cast<std::size_t>(r)]; std::ranges::count(joints, j) > 0)
      data.rows(r, growth + j) = std::abs(load[r]) * data.rows(r, coulomb + j);
}

/// What the regression predicts, and the growth that it finds.
struct UnderLoad {
  Eigen::VectorXd load;    ///< (N)
  Eigen::VectorXd growth;  ///< (n)
  Eigen::VectorXd sigma;   ///< (n)
};

UnderLoad weigh_under_load(const dynamics::RobotModel& robot, const Regression& data,
                           const RigidBodyOptions& options, GearSide side) {
  const int n = robot.n();
  const Unknowns unknowns = unknowns_of(robot, data, options);
  const Eigen::MatrixXd X = pick(data.rows, unknowns.columns);
  const Weighted solved = reweight(X, data.tau, data.joint, n, options.robust,
                                   unknowns.prior_information, unknowns.prior_mean);
  const Eigen::Index loading = side == GearSide::kMotor ? X.cols() : unknowns.head();
  UnderLoad out{X.leftCols(loading) * solved.x.head(loading), Eigen::VectorXd::Zero(n),
                solved.sigma};
  const int growth = robot.parameter_count() + 3 * n;
  for (std::size_t k = 0; k < unknowns.columns.size(); ++k)
    if (unknowns.columns[k] >= growth)
      out.growth[unknowns.columns[k] - growth] = solved.x[static_cast<Eigen::Index>(k)];
  return out;
}

/// Whether growth explains far more of a joint. @param sigma  (n) of the residuals without
bool explains_more(const UnderLoad& found, const Eigen::VectorXd& sigma) {
  return ((found.growth.array() > kLeastGrowth) &&
          (2 * (sigma.array() / found.sigma.array()).log() > kGrowthGain))
      .any();
}

/// Repeats the regression until the load that it predicts is that of the growth that it finds, in
/// the last columns of `data`.
/// @return joints whose friction grows; none where growth does not explain far more of any
std::vector<int> find_growth(const dynamics::RobotModel& robot, const RigidBodyOptions& options,
                             const RigidBodyFit& without, GearSide side, Regression& data) {
  const int n = robot.n();
  data.rows.rightCols(n).setZero();
  UnderLoad found = weigh_under_load(robot, data, options, side);
  std::vector<int> growing;
  for (int j = 0; j < n; ++j)
    if (without.Fc_se[j] > 0) growing.push_back(j);
  for (int pass = 0; pass < kLoadPasses; ++pass) {
    set_growth(growing, n, found.load, data);
    const UnderLoad next = weigh_under_load(robot, data, options, side);
    const double change = (next.growth - found.growth).cwiseAbs().maxCoeff();
    found = next;
    if (!explains_more(found, without.sigma)) return {};
    const auto falls = [&](int j) { return !(found.growth[j] > 0); };
    if (std::erase_if(growing, falls) == 0 && change < kStillGrowth) break;
  }
  return growing;
}

bool is_certain_growth(const RigidBodyFit& fit) {
  return ((fit.growth.array() > kGrowthErrors * fit.growth_se.array()) &&
          (fit.growth.array() > kLeastGrowth))
      .any();
}

/// Log of the geometric mean over the joints of what a regression leaves.
double spread(const RigidBodyFit& fit) { return fit.sigma.array().log().mean(); }

}  // namespace

bool RigidBodyFit::shows_growth(int joint) const {
  return growth.size() > joint && data::FittedLoadGrowth::is_seen(growth[joint], growth_se[joint]);
}

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
  const NoiseRows noise = draw_noise_rows(robot, sequences, data, options.cutoff_hz);
  RigidBodyOptions used = options;
  RigidBodyFit fit = solve(robot, sequences, data, noise, used, counts);
  std::string why = options.prior.use ? "asked for" : "";
  if (options.prior_where_needed && !options.prior.use) {
    why = undetermined(fit);
    used.prior.use = !why.empty();
    if (used.prior.use) fit = solve(robot, sequences, data, noise, used, counts);
  }
  if (const std::vector<JointInertia> without = fit.without_inertia;
      options.prior_where_needed && !without.empty()) {
    dynamics::RobotModel held = robot;
    for (const JointInertia& joint : without) {
      used.held_armatures.push_back(joint.joint);
      if (std::ranges::count(options.guesses.armature, joint.joint) > 0)
        held.pi[held.armature_begin() + joint.joint] *= kLeastUsual;
    }
    fit = solve(held, sequences, data, noise, used, counts);
    fit.without_inertia = without;
  }
  fit.prior = why;
  fit.slower = slower_than_asked(robot, options, fit.least_speed);
  fit.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  return fit;
}

std::optional<RigidBodyFit> rigid_body_under_load(const dynamics::RobotModel& robot,
                                                  std::span<const signals::Recording> sequences,
                                                  const RigidBodyOptions& options,
                                                  const RigidBodyFit& without) {
  const int n = robot.n();
  if (without.sigma.size() != n) return {};
  const RigidBodyOptions known = as_needed(options, without);
  RigidBodyFit counts;
  Regression data = with_room_for_growth(stack(robot, sequences, known, nullptr, counts), n);
  const NoiseRows noise = draw_noise_rows(robot, sequences, data, options.cutoff_hz);
  std::optional<RigidBodyFit> best;
  for (const GearSide side : {GearSide::kMotor, GearSide::kLink}) {
    const std::vector<int> growing = find_growth(robot, known, without, side, data);
    if (growing.empty()) continue;
    RigidBodyFit fit = solve(robot, sequences, data, noise, known, counts);
    fit.growth_of = side;
    if (is_certain_growth(fit) && (!best || spread(fit) < spread(*best))) best = std::move(fit);
  }
  if (!best) return {};
  best->prior = without.prior;
  best->slower = without.slower;
  best->without_inertia = without.without_inertia;
  return best;
}

void widen_errors(const RigidBodyFit& under_load, RigidBodyFit& fit) {
  fit.growth = under_load.growth;
  fit.growth_se = under_load.growth_se;
  fit.growth_of = under_load.growth_of;
  const auto widen = [](Eigen::VectorXd& error, const Eigen::VectorXd& value,
                        const Eigen::VectorXd& of_other) {
    if (value.size() == of_other.size())
      error = (error.array().square() + (value - of_other).array().square()).sqrt();
  };
  widen(fit.base_se, fit.base, under_load.base);
  widen(fit.Fc_se, fit.Fc, under_load.Fc);
  widen(fit.Fv_se, fit.Fv, under_load.Fv);
  widen(fit.offset_se, fit.offset, under_load.offset);
}

}  // namespace fricid::estimate
