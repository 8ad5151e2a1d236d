#include "rigid_body/contradictions.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include <fmt/format.h>

#include "fricid/base/eigen_instances.hpp"
#include "fricid/dynamics/base_parameters.hpp"
#include "fricid/system/transmission.hpp"
#include "rigid_body/information.hpp"
#include "rigid_body/regression.hpp"
#include "rigid_body/reweight.hpp"

namespace fricid::estimate {
namespace {

using dynamics::LinearTorque;

constexpr double kWidth = 0.5;       // sd of a factor's prior about 1
constexpr int kMostSteps = 40;       // of Gauss-Newton
constexpr double kConverged = 1e-3;  // change of a factor
constexpr double kSmallest = 0.02;   // factor over the largest: below, no torque of these bodies
constexpr int kPasses = 3;           // of friction that grows with the load of the last pass
// Log of the factor by which the unexplained variances must fall, in sum over the joints: friction
// that the linear regression has not lets springs and factors gain up to 1.8.
constexpr double kGain = 2.5;
constexpr double kLeast = 0.03, kCertain = 4;  // distance of a factor from 1: [1], standard errors

/// Linear regression on the base parameters and the friction that any row excites.
struct Stacked {
  Regression data;
  std::vector<int> columns;  ///< base parameters, then friction
  Eigen::Index base = 0;     ///< number of the former

  Eigen::MatrixXd X() const { return data.rows(Eigen::all, columns); }
};

Stacked stacked(const dynamics::RobotModel& robot, std::span<const signals::Recording> recordings,
                const RigidBodyOptions& options) {
  RigidBodyFit counts;
  Stacked all{stack(robot, recordings, options, nullptr, counts),
              dynamics::base_parameters(robot).columns};
  all.base = std::ssize(all.columns);
  const int p = robot.parameter_count();
  for (int k = p; k < p + 3 * robot.n(); ++k)
    if (all.data.rows.col(k).squaredNorm() > 0) all.columns.push_back(k);
  return all;
}

/// Least squares of tau on X, each joint's noise being its own.
Weighted solve(const Eigen::MatrixXd& X, const Regression& data, int n) {
  return reweight(X, data.tau, data.joint, n, false, Eigen::MatrixXd::Zero(X.cols(), X.cols()),
                  Eigen::VectorXd::Zero(X.cols()));
}

/// Writes friction that grows with the load, F[sign v_j] |Y pi|, to the n last columns of X.
/// @param rigid  (N) Y pi
void set_growth(const Eigen::VectorXd& rigid, const Regression& data, int n, Eigen::Index first,
                Eigen::MatrixXd& X) {
  const Eigen::Index coulomb = data.rows.cols() - 3 * n;
  X.middleCols(first, n).setZero();
  for (Eigen::Index r = 0; r < X.rows(); ++r) {
    const int j = data.joint[static_cast<std::size_t>(r)];
    X(r, first + j) = data.rows(r, coulomb + j) * std::abs(rigid[r]);
  }
}

/// Standard deviation of the residuals of each joint.
Eigen::VectorXd sigma_of(const Eigen::VectorXd& residual, const std::vector<int>& joint, int n) {
  Eigen::VectorXd squares = Eigen::VectorXd::Zero(n), count = Eigen::VectorXd::Zero(n);
  for (std::size_t r = 0; r < joint.size(); ++r) {
    squares[joint[r]] += std::pow(residual[static_cast<Eigen::Index>(r)], 2);
    count[joint[r]] += 1;
  }
  return (squares.array() / count.array().max(1)).max(1e-24).sqrt().matrix();
}

double gain_of(const Eigen::VectorXd& sigma, const Eigen::VectorXd& less) {
  return 2 * (sigma.array() / less.array()).log().sum();
}

int middle_of(const Eigen::VectorXd& x) {
  std::vector<int> order(static_cast<std::size_t>(x.size()));
  std::iota(order.begin(), order.end(), 0);
  std::ranges::sort(order, {}, [&](int j) { return x[j]; });
  return order[order.size() / 2];
}

/// Factors s of the torque columns of a robot whose joints share inertial parameters:
///
///     tau_j = s_j Y_j pi + Fc_j F[sign v_j] + Fv_j v_j + offset_j + e_j.
///
/// Their common factor is that of all masses and cannot be told: the middle one is called 1.
struct TorqueScales {
  Eigen::VectorXd value;           ///< (n); empty: not found
  Eigen::VectorXd standard_error;  ///< (n)
  /// Log of the factor by which they lower the unexplained variance, in sum over the joints.
  double gain = 0;
};

/// Joints whose factor is not 1, where the factors explain far more.
std::vector<int> scaled_joints(const TorqueScales& scales) {
  std::vector<int> joints;
  for (int j = 0; j < static_cast<int>(scales.value.size()); ++j)
    if (const double off = std::abs(scales.value[j] - 1);
        off > std::max(kLeast, kCertain * scales.standard_error[j]))
      joints.push_back(j);
  return joints;
}

/// The robot with a spring at joint j beside gravity.
dynamics::RobotModel with_spring(dynamics::RobotModel robot, int j) {
  using enum LinearTorque::Shape;
  for (const LinearTorque::Shape shape : {kLinear, kSin, kCos}) {
    const auto is_it = [&](const LinearTorque& torque) {
      return torque.joint == j && torque.shape == shape && torque.k == 1;
    };
    if (std::ranges::none_of(robot.linear_torques, is_it))
      dynamics::add_linear_torque(robot, {.name = "spring", .joint = j, .shape = shape, .k = 1});
  }
  return robot;
}

/// The joints whose springs, one after the other, explain most.
struct Springs {
  std::vector<int> joints;
  double gain = 0;
};

/// @param sigma  of the residuals without springs
Springs find_springs(dynamics::RobotModel robot, std::span<const signals::Recording> recordings,
                     const RigidBodyOptions& options, Eigen::VectorXd sigma) {
  Springs springs;
  const int n = robot.n();
  for (double best = kGain; best > 0;) {
    best = 0;
    std::pair<int, Eigen::VectorXd> with;
    for (int j = 0; j < n; ++j) {
      if (std::ranges::count(springs.joints, j) > 0) continue;
      const Stacked all = stacked(with_spring(robot, j), recordings, options);
      if (all.data.rows.rows() <= std::ssize(all.columns)) continue;
      const Eigen::VectorXd less = solve(all.X(), all.data, n).sigma;
      if (const double gain = gain_of(sigma, less); gain > std::max(best, kGain))
        best = gain, with = {j, less};
    }
    if (best == 0) break;
    springs.joints.push_back(with.first);
    springs.gain += best;
    robot = with_spring(std::move(robot), with.first);
    sigma = with.second;
  }
  return springs;
}

/// Log of the share of the torque's variance that a regression leaves, in sum over the joints.
double log_unexplained(std::span<const signals::Recording> recordings, const RigidBodyFit& fit) {
  double sum = 0;
  for (Eigen::Index j = 0; j < fit.sigma.size(); ++j) {
    double torque = 0, square = 0, count = 0;
    for (const signals::Recording& r : recordings) {
      torque += r.filtered_tau.col(j).sum();
      square += r.filtered_tau.col(j).squaredNorm();
      count += static_cast<double>(r.filtered_tau.rows());
    }
    sum += std::log(fit.sigma[j] * fit.sigma[j] / (square / count - std::pow(torque / count, 2)));
  }
  return sum;
}

/// Torque columns of a robot with coupled motors that explain far more if they are read otherwise.
std::vector<Fault> find_misread_columns(const dynamics::RobotModel& robot,
                                        std::span<const signals::Recording> recordings,
                                        const RigidBodyOptions& options, const RigidBodyFit& fit) {
  std::vector<Fault> faults;
  if (!robot.coupled()) return faults;
  const double as_read = log_unexplained(recordings, fit);
  const Transmission transmission(robot);
  double best = kGain;
  for (const bool of_motors : {true, false}) {
    std::vector<signals::Recording> other(recordings.begin(), recordings.end());
    for (signals::Recording& r : other)
      r.filtered_tau = of_motors ? transmission.torque_to_joints(r.filtered_tau)
                                 : transmission.torque_to_motors(r.filtered_tau);
    const RigidBodyFit of_other = rigid_body_least_squares(robot, other, options);
    if (of_other.sigma.size() == 0) continue;
    const double gain = as_read - log_unexplained(other, of_other);
    if (!(gain > best)) continue;
    best = gain;
    faults = {
        {"",
         fmt::format("the torque leaves {:.0f} times less unexplained if its columns are those of "
                     "{}",
                     std::exp(gain), of_motors ? "the coupled motors" : "joints"),
         of_motors ? "in the contract [[coupling]] and kind = \"motor_torque\" (gear_ratio 1 where "
                     "the columns are multiplied by it), or log the torque about the joints"
                   : "kind = \"joint_torque\" in the contract, and [[robot.coupling]] in the "
                     "scene"}};
  }
  return faults;
}

/// Least squares in pi, s and friction by Gauss-Newton, no prior but s_j = 1 +- 0.5.
/// @param plain  solution of `all` with s = 1
TorqueScales find_torque_scales(const Stacked& all, const Weighted& plain, int n) {
  const Regression& data = all.data;
  const Eigen::Index b = all.base, m = std::ssize(all.columns);
  if (n < 2 || data.rows.rows() <= m + 2 * n) return {};

  // Unknowns: base parameters, linear friction, growth of friction with the load, and the factors
  // s. About pi and s of the last step
  //     tau + s (Y pi) = s Y pi_new + (Y pi) s_new + friction.
  const Eigen::Index growth = m, factors = m + n, size = m + 2 * n;
  Eigen::MatrixXd X = Eigen::MatrixXd::Zero(data.rows.rows(), size);
  X.leftCols(m) = all.X();
  const Eigen::MatrixXd Y = X.leftCols(b);
  Weighted apart = plain;
  for (int pass = 0; pass < kPasses; ++pass) {
    set_growth(Y * apart.x.head(b), data, n, growth, X);
    apart = solve(X.leftCols(factors), data, n);
  }
  Eigen::MatrixXd prior = Eigen::MatrixXd::Zero(size, size);
  prior.bottomRightCorner(n, n).diagonal().setConstant(std::pow(kWidth, -2));
  Eigen::VectorXd pi = apart.x.head(b), s = Eigen::VectorXd::Ones(n), y = data.tau;
  Weighted solved{.x = {}, .H = {}, .sigma = apart.sigma, .weight = apart.weight};
  double change = 1;
  for (int step = 0; step < kMostSteps && change > kConverged; ++step) {
    const Eigen::VectorXd rigid = Y * pi;
    set_growth(rigid, data, n, growth, X);
    X.rightCols(n).setZero();
    for (Eigen::Index r = 0; r < X.rows(); ++r) {
      const int j = data.joint[static_cast<std::size_t>(r)];
      X.row(r).head(b) = s[j] * Y.row(r);
      X(r, factors + j) = rigid[r];
      y[r] = data.tau[r] + s[j] * rigid[r];
      solved.weight[r] = std::pow(solved.sigma[j], -2);
    }
    const Eigen::MatrixXd weighted = solved.weight.asDiagonal() * X;
    solved.H = X.transpose() * weighted + prior;
    solved.x = invert(solved.H, nullptr) *
               (weighted.transpose() * y + prior * Eigen::VectorXd::Ones(size));
    if (!solved.x.allFinite()) return {};
    solved.sigma = sigma_of(y - X * solved.x, data.joint, n);
    change = (solved.x.tail(n) - s).cwiseAbs().maxCoeff();
    pi = solved.x.head(b);
    s = solved.x.tail(n);
  }
  if (change > kConverged || !(s.minCoeff() > kSmallest * s.maxCoeff())) return {};

  const Eigen::MatrixXd root = jackknife_root(X, y, solved, data.block, prior).bottomRows(n);
  const int middle = middle_of(s);
  TorqueScales scales{s / s[middle], Eigen::VectorXd::Zero(n), gain_of(apart.sigma, solved.sigma)};
  for (int j = 0; j < n; ++j)
    scales.standard_error[j] =
        (root.row(j) - root.row(middle) * scales.value[j]).norm() / s[middle];
  return scales;
}

}  // namespace

std::vector<Fault> find_contradictions(const dynamics::RobotModel& robot,
                                       std::span<const signals::Recording> recordings,
                                       const RigidBodyOptions& options, const RigidBodyFit& fit) {
  if (fit.sigma.size() == 0) return {};
  std::vector<Fault> faults = find_misread_columns(robot, recordings, options, fit);
  if (!faults.empty() || !fit.prior.empty()) return faults;
  const Stacked all = stacked(robot, recordings, options);
  const Weighted plain = solve(all.X(), all.data, robot.n());
  const TorqueScales scales = find_torque_scales(all, plain, robot.n());
  const Springs springs = find_springs(robot, recordings, options, plain.sigma);
  const auto name = [&](int j) { return robot.joints[static_cast<std::size_t>(j)].name; };
  if (springs.gain > scales.gain) {
    for (const int j : springs.joints)
      faults.push_back({name(j),
                        "its torque goes with its own angle more than gravity and inertia explain",
                        fmt::format("a spring, counterbalance or cable that the robot's file "
                                    "lacks: [[robot.torque]] joint = \"{}\", terms = [\"q\", "
                                    "\"sin(q)\", \"cos(q)\"]",
                                    name(j))});
  } else if (scales.gain > kGain) {
    for (const int j : scaled_joints(scales))
      faults.push_back(
          {name(j),
           fmt::format("its torque is {:.3g} +- {:.1g} times what the other joints say of the "
                       "bodies that it moves",
                       scales.value[j], scales.standard_error[j]),
           fmt::format("correct its torque constant, gear ratio or scale: scale of [torque] in the "
                       "contract, {:.3g} times what it is, makes them agree",
                       1 / scales.value[j])});
  }
  return faults;
}

}  // namespace fricid::estimate
