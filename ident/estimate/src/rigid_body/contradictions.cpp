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
#include "support.hpp"

namespace fricid::estimate {
namespace {

using dynamics::LinearTorque;

constexpr double kWidth = 0.5;       // sd of a factor's prior about 1
constexpr int kWeighings = 12;       // by the noise of the joints
constexpr int kMostSteps = 40;       // of Gauss-Newton
constexpr double kConverged = 1e-3;  // change of a factor
constexpr double kSmallest = 0.02;   // factor over the largest: below, no torque of these bodies
constexpr int kPasses = 3;           // of friction that grows with the load of the last pass
// Log of the factor by which the unexplained variances must fall, in sum over the joints: friction
// that the linear regression has not lets springs and factors gain up to 1.8.
constexpr double kGain = 2.5;
constexpr double kLeast = 0.03, kCertain = 4;  // distance of a factor from 1: [1], standard errors

using Columns = std::vector<Eigen::Index>;

/// The robot with a spring, c0 q + c1 sin q + c2 cos q, at every joint beside gravity; c0 q where
/// it slides.
dynamics::RobotModel with_springs(dynamics::RobotModel robot) {
  using enum LinearTorque::Shape;
  for (int j = 0; j < robot.n(); ++j)
    for (const LinearTorque::Shape shape : {kLinear, kSin, kCos}) {
      if (shape != kLinear && dynamics::slides(robot.joints[static_cast<std::size_t>(j)])) continue;
      const auto is_it = [&](const LinearTorque& torque) {
        return torque.joint == j && torque.shape == shape && torque.k == 1;
      };
      if (std::ranges::none_of(robot.linear_torques, is_it))
        dynamics::add_linear_torque(robot, {.name = "spring", .joint = j, .shape = shape, .k = 1});
    }
  return robot;
}

/// The rows of one joint, y = X x + e, and their normal equations.
struct JointRows {
  Columns at;  ///< in the stacked regression
  Eigen::MatrixXd X, XX;
  Eigen::VectorXd y, Xy;

  void set_column(Eigen::Index k, const Eigen::VectorXd& x) {
    X.col(k) = x;
    XX.row(k) = x.transpose() * X;
    XX.col(k) = XX.row(k).transpose();
    Xy[k] = x.dot(y);
  }
  /// ||y - X x||^2
  double squares(const Eigen::VectorXd& x) const {
    return std::max(0.0, y.squaredNorm() - x.dot(2 * Xy - XX * x));
  }
};

/// The torque of a robot in all columns that may explain it, by joint. Each joint's noise is its
/// own, so that every regression on some of the columns follows from the normal equations.
struct Stacked {
  std::vector<JointRows> joints;
  std::vector<Eigen::VectorXd> coulomb;  ///< of each joint: F[sign v_j]
  std::vector<int> block;                ///< of each row; see `Regression`
  Eigen::Index rows = 0;
  /// First the base parameters of the robot as it is given, then friction that any row excites,
  /// friction that grows with the load (n), springs.
  Eigen::Index base = 0, plain = 0, with_growth = 0, size = 0;
  std::vector<Columns> springs;  ///< of each joint

  int n() const { return static_cast<int>(joints.size()); }
  Columns first(Eigen::Index count) const {
    Columns columns(static_cast<std::size_t>(count));
    std::iota(columns.begin(), columns.end(), 0);
    return columns;
  }
};

Stacked stack_all(const dynamics::RobotModel& robot, std::span<const signals::Recording> recordings,
                  const RigidBodyOptions& options) {
  const dynamics::RobotModel sprung = with_springs(robot);
  const int n = robot.n(), p = sprung.parameter_count();
  RigidBodyFit counts;
  const Regression data = stack(sprung, recordings, options, nullptr, counts);
  Stacked all;
  all.block = data.block;
  all.rows = data.rows.rows();
  std::vector<int> columns, of_springs;
  for (const int k : dynamics::base_parameters(sprung).columns)
    (k < robot.parameter_count() ? columns : of_springs).push_back(k);
  all.base = std::ssize(columns);
  for (int k = p; k < p + 3 * n; ++k)
    if (data.rows.col(k).squaredNorm() > 0) columns.push_back(k);
  all.plain = std::ssize(columns);
  all.with_growth = all.plain + n;
  all.size = all.with_growth + std::ssize(of_springs);
  all.springs.resize(static_cast<std::size_t>(n));
  for (std::size_t i = 0; i < of_springs.size(); ++i) {
    const auto k = static_cast<std::size_t>(of_springs[i] - sprung.linear_begin());
    all.springs[static_cast<std::size_t>(sprung.linear_torques[k].joint)].push_back(
        all.with_growth + static_cast<Eigen::Index>(i));
  }

  for (int j = 0; j < n; ++j) {
    JointRows rows;
    for (std::size_t r = 0; r < data.joint.size(); ++r)
      if (data.joint[r] == j) rows.at.push_back(static_cast<Eigen::Index>(r));
    rows.X.setZero(std::ssize(rows.at), all.size);
    rows.X.leftCols(all.plain) = data.rows(rows.at, columns);
    rows.X.rightCols(std::ssize(of_springs)) = data.rows(rows.at, of_springs);
    rows.y = data.tau(rows.at);
    rows.XX = rows.X.transpose() * rows.X;
    rows.Xy = rows.X.transpose() * rows.y;
    all.coulomb.push_back(data.rows(rows.at, p + j));
    all.joints.push_back(std::move(rows));
  }
  return all;
}

/// Writes friction that grows with the load, F[sign v_j] |Y_j pi|, to its columns.
void set_growth(const Eigen::VectorXd& pi, Stacked& all) {
  for (int j = 0; j < all.n(); ++j) {
    const auto at = static_cast<std::size_t>(j);
    JointRows& rows = all.joints[at];
    const Eigen::VectorXd rigid = rows.X.leftCols(all.base) * pi;
    rows.set_column(all.plain + j, all.coulomb[at].cwiseProduct(rigid.cwiseAbs()));
  }
}

struct Solution {
  Eigen::VectorXd x;
  Eigen::VectorXd sigma;  ///< of the residuals of each joint
};

double sigma_of(double squares, const JointRows& rows) {
  const double floor = kSmallestSigma * rows.y.norm();
  return std::sqrt(std::max({squares, floor * floor, 1e-300}) /
                   std::max(1.0, static_cast<double>(rows.at.size())));
}

/// Least squares on some columns, weighed by the noise that it leaves to each joint.
Solution solve(const Stacked& all, const Columns& columns) {
  const auto m = std::ssize(columns);
  Solution solution{{}, Eigen::VectorXd::Zero(all.n())};
  for (int j = 0; j < all.n(); ++j) {
    const JointRows& rows = all.joints[static_cast<std::size_t>(j)];
    solution.sigma[j] = sigma_of(rows.y.squaredNorm(), rows);
  }
  for (int i = 0; i < kWeighings; ++i) {
    Eigen::MatrixXd H = Eigen::MatrixXd::Zero(m, m);
    Eigen::VectorXd g = Eigen::VectorXd::Zero(m);
    for (int j = 0; j < all.n(); ++j) {
      const JointRows& rows = all.joints[static_cast<std::size_t>(j)];
      const double weight = std::pow(solution.sigma[j], -2);
      H += weight * rows.XX(columns, columns);
      g += weight * rows.Xy(columns);
    }
    solution.x = Eigen::VectorXd::Zero(all.size);
    solution.x(columns) = invert(H, nullptr) * g;
    for (int j = 0; j < all.n(); ++j) {
      const JointRows& rows = all.joints[static_cast<std::size_t>(j)];
      solution.sigma[j] = sigma_of(rows.squares(solution.x), rows);
    }
  }
  return solution;
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
  Eigen::VectorXd standard_error;  ///< (n); 0 where the gain is not worth a word
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

/// The joints whose springs, one after the other, explain most.
struct Springs {
  std::vector<int> joints;
  double gain = 0;
};

/// @param sigma  of the residuals without springs
Springs find_springs(const Stacked& all, Eigen::VectorXd sigma) {
  Springs springs;
  Columns columns = all.first(all.plain);
  for (double best = kGain; best > 0;) {
    best = 0;
    std::pair<int, Eigen::VectorXd> with;
    for (int j = 0; j < all.n(); ++j) {
      const Columns& own = all.springs[static_cast<std::size_t>(j)];
      if (own.empty() || std::ranges::count(springs.joints, j) > 0) continue;
      Columns more = columns;
      more.insert(more.end(), own.begin(), own.end());
      if (all.rows <= std::ssize(more)) continue;
      const Eigen::VectorXd less = solve(all, more).sigma;
      if (const double gain = gain_of(sigma, less); gain > std::max(best, kGain))
        best = gain, with = {j, less};
    }
    if (best == 0) break;
    const Columns& own = all.springs[static_cast<std::size_t>(with.first)];
    columns.insert(columns.end(), own.begin(), own.end());
    springs.joints.push_back(with.first);
    springs.gain += best;
    sigma = with.second;
  }
  return springs;
}

/// A joint that slides has no angle: what depends on its position is a spring or an offset.
Fault spring_at(const dynamics::Joint& joint) {
  const bool slides = dynamics::slides(joint);
  return {joint.name,
          fmt::format("its {} goes with its own {} more than gravity and inertia explain",
                      slides ? "force" : "torque", slides ? "position" : "angle"),
          fmt::format("a spring, counterbalance or cable that the robot's file lacks: "
                      "[[robot.torque]] joint = \"{}\", terms = [{}]",
                      joint.name, slides ? "\"q\"" : "\"q\", \"sin(q)\", \"cos(q)\"")};
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

/// Columns of joint j for the unknowns base parameters, friction and growth, factors s (n), about
/// pi and s: with the target y + s_j Y pi the row is
///
///     s_j Y pi_new + s_new,j (Y pi) + friction.
Eigen::MatrixXd about(const Stacked& all, const Eigen::VectorXd& pi, double s, int j) {
  Eigen::MatrixXd T = Eigen::MatrixXd::Zero(all.size, all.with_growth + all.n());
  T.topLeftCorner(all.with_growth, all.with_growth).setIdentity();
  T.diagonal().head(all.base).setConstant(s);
  T.col(all.with_growth + j).head(all.base) = pi;
  return T;
}

/// Standard errors of the factors over the middle one by the jackknife.
/// @param solved  information and weights at the solution pi, s
Eigen::VectorXd errors_of(const Stacked& all, const Eigen::VectorXd& pi, const Eigen::VectorXd& s,
                          Weighted solved, const Eigen::VectorXd& sigma,
                          const Eigen::MatrixXd& prior) {
  const int n = all.n();
  Eigen::MatrixXd X(all.rows, solved.x.size());
  Eigen::VectorXd y(all.rows);
  solved.weight.resize(all.rows);
  for (int j = 0; j < n; ++j) {
    const JointRows& rows = all.joints[static_cast<std::size_t>(j)];
    X(rows.at, Eigen::all) = rows.X * about(all, pi, s[j], j);
    y(rows.at) = rows.y + s[j] * (rows.X.leftCols(all.base) * pi);
    solved.weight(rows.at).setConstant(std::pow(sigma[j], -2));
  }
  const Eigen::MatrixXd root = jackknife_root(X, y, solved, all.block, prior).bottomRows(n);
  const int middle = middle_of(s);
  Eigen::VectorXd errors(n);
  for (int j = 0; j < n; ++j)
    errors[j] = (root.row(j) - root.row(middle) * (s[j] / s[middle])).norm() / s[middle];
  return errors;
}

/// Least squares in pi, s and friction by Gauss-Newton, no prior but s_j = 1 +- 0.5.
/// @param plain  solution with s = 1 and without growth
TorqueScales find_torque_scales(Stacked all, const Solution& plain) {
  const int n = all.n();
  const Eigen::Index size = all.with_growth + n;
  if (n < 2 || all.rows <= size) return {};
  Solution apart = plain;
  for (int pass = 0; pass < kPasses; ++pass) {
    set_growth(apart.x.head(all.base), all);
    apart = solve(all, all.first(all.with_growth));
  }
  Eigen::MatrixXd prior = Eigen::MatrixXd::Zero(size, size);
  prior.bottomRightCorner(n, n).diagonal().setConstant(std::pow(kWidth, -2));
  Eigen::VectorXd pi = apart.x.head(all.base), s = Eigen::VectorXd::Ones(n), sigma = apart.sigma;
  Weighted solved;
  double change = 1;
  for (int step = 0; step < kMostSteps && change > kConverged; ++step) {
    set_growth(pi, all);
    solved.H = prior;
    Eigen::VectorXd g = prior * Eigen::VectorXd::Ones(size);
    std::vector<Eigen::MatrixXd> T;
    for (int j = 0; j < n; ++j) {
      const JointRows& rows = all.joints[static_cast<std::size_t>(j)];
      const double weight = std::pow(sigma[j], -2);
      T.push_back(about(all, pi, s[j], j));
      solved.H += weight * (T.back().transpose() * (rows.XX * T.back()));
      g += weight * (T.back().transpose() * (rows.Xy + s[j] * (rows.XX.leftCols(all.base) * pi)));
    }
    solved.x = invert(solved.H, nullptr) * g;
    if (!solved.x.allFinite()) return {};
    for (int j = 0; j < n; ++j) {
      const JointRows& rows = all.joints[static_cast<std::size_t>(j)];
      Eigen::VectorXd x = T[static_cast<std::size_t>(j)] * solved.x;
      x.head(all.base) -= s[j] * pi;
      sigma[j] = sigma_of(rows.squares(x), rows);
    }
    change = (solved.x.tail(n) - s).cwiseAbs().maxCoeff();
    pi = solved.x.head(all.base);
    s = solved.x.tail(n);
  }
  if (change > kConverged || !(s.minCoeff() > kSmallest * s.maxCoeff())) return {};
  TorqueScales scales{s / s[middle_of(s)], Eigen::VectorXd::Zero(n), gain_of(apart.sigma, sigma)};
  if (scales.gain > kGain) scales.standard_error = errors_of(all, pi, s, solved, sigma, prior);
  return scales;
}

}  // namespace

std::vector<Fault> find_contradictions(const dynamics::RobotModel& robot,
                                       std::span<const signals::Recording> recordings,
                                       const RigidBodyOptions& options, const RigidBodyFit& fit) {
  if (fit.sigma.size() == 0) return {};
  std::vector<Fault> faults = find_misread_columns(robot, recordings, options, fit);
  if (!faults.empty() || !fit.prior.empty()) return faults;
  const Stacked all = stack_all(robot, recordings, options);
  const Solution plain = solve(all, all.first(all.plain));
  const TorqueScales scales = find_torque_scales(all, plain);
  const Springs springs = find_springs(all, plain.sigma);
  const auto name = [&](int j) { return robot.joints[static_cast<std::size_t>(j)].name; };
  if (springs.gain > scales.gain) {
    for (const int j : springs.joints)
      faults.push_back(spring_at(robot.joints[static_cast<std::size_t>(j)]));
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
