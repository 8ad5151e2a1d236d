#include "rigid_body/joint_rows.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <numeric>
#include <utility>

#include <fmt/format.h>

#include "fricid/base/eigen_instances.hpp"
#include "fricid/dynamics/base_parameters.hpp"
#include "rigid_body/information.hpp"
#include "rigid_body/regression.hpp"
#include "rigid_body/reweight.hpp"
#include "support.hpp"

namespace fricid::estimate {
namespace {

using dynamics::LinearTorque;

constexpr int kWeighings = 12;  // by the noise of the joints
constexpr double kSlow = 0.2;   // of the mean speed, within which the second curve falls

/// The robot with a spring at every joint beside gravity; linear where it slides.
dynamics::RobotModel with_springs(dynamics::RobotModel robot) {
  using enum LinearTorque::Shape;
  for (int j = 0; j < robot.n(); ++j)
    for (const LinearTorque::Shape shape : {kLinear, kSin, kCos}) {
      if (shape != kLinear && slides(robot.joints[static_cast<std::size_t>(j)])) continue;
      const auto is_it = [&](const LinearTorque& torque) {
        return torque.joint == j && torque.shape == shape && torque.k == 1;
      };
      if (std::ranges::none_of(robot.linear_torques, is_it))
        dynamics::add_linear_torque(robot, {.name = "spring", .joint = j, .shape = shape, .k = 1});
    }
  return robot;
}

Columns first_columns(Eigen::Index count) {
  Columns columns(static_cast<std::size_t>(count));
  std::iota(columns.begin(), columns.end(), 0);
  return columns;
}

}  // namespace

void JointRows::set_column(Eigen::Index k, const Eigen::VectorXd& x) {
  X.col(k) = x;
  XX.row(k) = x.transpose() * X;
  XX.col(k) = XX.row(k).transpose();
  Xy[k] = x.dot(y);
}

double JointRows::squares(const Eigen::VectorXd& x) const {
  return std::max(0.0, yy - x.dot(2 * Xy - XX * x));
}

void JointRows::add(const JointRows& other) {
  XX += other.XX;
  Xy += other.Xy;
  yy += other.yy;
  count += other.count;
}

JointRows normal_equations(const Eigen::MatrixXd& X, const Eigen::VectorXd& y) {
  JointRows rows;
  rows.XX = X.transpose() * X;
  rows.Xy = X.transpose() * y;
  rows.yy = y.squaredNorm();
  rows.count = static_cast<double>(y.size());
  return rows;
}

JointRows with_rows(Columns at, Eigen::MatrixXd X, const Eigen::VectorXd& y) {
  JointRows rows = normal_equations(X, y);
  rows.at = std::move(at);
  rows.X = std::move(X);
  rows.y = y;
  return rows;
}

JointRows normal_equations(const JointRows& joint, const Columns& chosen, Eigen::Index columns) {
  return normal_equations(joint.X.leftCols(columns)(chosen, Eigen::all), joint.y(chosen));
}

std::vector<int> StackedByJoint::joint_of_rows() const {
  std::vector<int> joint(static_cast<std::size_t>(rows));
  for (int j = 0; j < n(); ++j)
    for (const Eigen::Index r : joints[static_cast<std::size_t>(j)].at)
      joint[static_cast<std::size_t>(r)] = j;
  return joint;
}

Eigen::VectorXd StackedByJoint::standard(const Eigen::VectorXd& x, int count) const {
  Eigen::VectorXd pi = Eigen::VectorXd::Zero(count);
  pi(parameters) = x.head(base);
  return pi;
}

StackedByJoint stack_by_joint(const dynamics::RobotModel& robot,
                              std::span<const signals::Recording> recordings,
                              const RigidBodyOptions& options) {
  const dynamics::RobotModel sprung = with_springs(robot);
  const int n = robot.n(), p = sprung.parameter_count();
  RigidBodyFit counts;
  const Regression data = stack(sprung, recordings, options, nullptr, counts);
  StackedByJoint all;
  all.passage = data.passage;
  all.sequence = data.sequence;
  all.sample = data.sample;
  all.rows = data.rows.rows();
  std::vector<int> columns, of_springs;
  for (const int k : dynamics::base_parameters(sprung).columns)
    (k < robot.parameter_count() ? columns : of_springs).push_back(k);
  dynamics::BaseParameters base = dynamics::base_parameters(robot);
  all.names = std::move(base.names);
  all.K = std::move(base.K);
  all.base = std::ssize(columns);
  all.parameters = columns;
  all.Fc = all.Fv = all.offset = Columns(static_cast<std::size_t>(n), -1);
  for (std::size_t i = 0; i < columns.size(); ++i) {
    if (columns[i] < robot.linear_begin()) continue;
    const LinearTorque& torque =
        robot.linear_torques[static_cast<std::size_t>(columns[i] - robot.linear_begin())];
    if (torque.shape == LinearTorque::Shape::kConstant)
      all.offset[static_cast<std::size_t>(torque.joint)] = static_cast<Eigen::Index>(i);
  }
  const char* kinds[] = {"Coulomb friction", "viscous friction", "constant torque"};
  Columns* of_kind[] = {&all.Fc, &all.Fv, &all.offset};
  for (int k = 0; k < 3 * n; ++k) {
    if (!(data.rows.col(p + k).squaredNorm() > 0)) continue;
    (*of_kind[k / n])[static_cast<std::size_t>(k % n)] = std::ssize(columns);
    columns.push_back(p + k);
    all.names.push_back(
        fmt::format("{} of {}", kinds[k / n], robot.joints[static_cast<std::size_t>(k % n)].name));
  }
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
    Columns at;
    for (std::size_t r = 0; r < data.joint.size(); ++r)
      if (data.joint[r] == j) at.push_back(static_cast<Eigen::Index>(r));
    Eigen::MatrixXd X = Eigen::MatrixXd::Zero(std::ssize(at), all.size);
    X.leftCols(all.plain) = data.rows(at, columns);
    X.rightCols(std::ssize(of_springs)) = data.rows(at, of_springs);
    all.coulomb.push_back(data.rows(at, p + j));
    const Eigen::VectorXd y = data.tau(at);
    all.joints.push_back(with_rows(std::move(at), std::move(X), y));
  }
  return all;
}

StackedByJoint with_curves(const StackedByJoint& all, std::span<const Eigen::VectorXd> loads) {
  StackedByJoint out;
  out.curves = loads.empty() ? 2 : 3;
  const Eigen::Index size = all.plain + out.curves * all.n();
  out.passage = all.passage;
  out.sequence = all.sequence;
  out.sample = all.sample;
  out.rows = all.rows;
  out.base = all.base;
  out.plain = out.with_growth = out.size = size;
  out.parameters = all.parameters;
  out.K = all.K;
  out.Fc = all.Fc;
  out.Fv = all.Fv;
  out.offset = all.offset;
  for (int j = 0; j < all.n(); ++j) {
    const auto at = static_cast<std::size_t>(j);
    const JointRows& rows = all.joints[at];
    Eigen::MatrixXd X = Eigen::MatrixXd::Zero(rows.X.rows(), size);
    X.leftCols(all.plain) = rows.X.leftCols(all.plain);
    if (all.Fc[at] >= 0 && all.Fv[at] >= 0 && X.rows() > 0) {
      const Eigen::ArrayXd direction = X.col(all.Fc[at]).array(),
                           speed = X.col(all.Fv[at]).array().abs();
      const Eigen::Index first = all.plain + out.curves * j;
      X.col(first) = direction * (speed / speed.mean()).sqrt();
      X.col(first + 1) = direction * (-speed / (kSlow * speed.mean())).exp();
      if (!loads.empty()) {
        const Eigen::ArrayXd load = loads[at].array().abs();
        X.col(first + 2) = direction * load / std::max(load.mean(), 1e-300);
      }
    }
    out.joints.push_back(with_rows(rows.at, std::move(X), rows.y));
  }
  return out;
}

StackedByJoint with_curves_under_load(const StackedByJoint& all) {
  const StackedByJoint unloaded = with_curves(all);
  const Solution solution = solve(unloaded, unloaded.plain);
  std::vector<Eigen::VectorXd> loads;
  for (const JointRows& joint : unloaded.joints) loads.emplace_back(joint.X * solution.x);
  return with_curves(all, loads);
}

StackedByJoint with_columns(const StackedByJoint& all, const std::vector<Eigen::MatrixXd>& more) {
  StackedByJoint out;
  out.rows = all.rows;
  out.passage = all.passage;
  out.size = out.plain = all.plain + more.front().cols();
  for (std::size_t j = 0; j < all.joints.size(); ++j) {
    const JointRows& rows = all.joints[j];
    Eigen::MatrixXd X(rows.X.rows(), out.size);
    X << rows.X.leftCols(all.plain), more[j];
    out.joints.push_back(with_rows(rows.at, std::move(X), rows.y));
  }
  return out;
}

Eigen::MatrixXd rows_by_sample(
    std::span<const int> joint, std::span<const int> sequence, std::span<const int> sample, int n,
    Eigen::Index columns,
    const std::function<void(int sequence, int sample, RowMatrix& of_sample)>& write) {
  RowMatrix of_sample(columns, n);
  Eigen::MatrixXd rows(std::ssize(joint), columns);
  for (std::size_t r = 0; r < joint.size(); ++r) {
    if (r == 0 || sample[r] != sample[r - 1] || sequence[r] != sequence[r - 1])
      write(sequence[r], sample[r], of_sample);
    rows.row(static_cast<Eigen::Index>(r)) = of_sample.col(joint[r]).transpose();
  }
  return rows;
}

std::vector<Eigen::MatrixXd> rows_by_sample(
    const StackedByJoint& all, Eigen::Index columns,
    const std::function<void(int sequence, int sample, RowMatrix& of_sample)>& write) {
  return of_joints(
      all, rows_by_sample(all.joint_of_rows(), all.sequence, all.sample, all.n(), columns, write));
}

std::vector<Eigen::MatrixXd> of_joints(const StackedByJoint& all, const Eigen::MatrixXd& rows) {
  std::vector<Eigen::MatrixXd> out;
  for (const JointRows& joint : all.joints) out.push_back(rows(joint.at, Eigen::all));
  return out;
}

void set_growth(const Eigen::VectorXd& pi, StackedByJoint& all) {
  for (int j = 0; j < all.n(); ++j) {
    const auto at = static_cast<std::size_t>(j);
    JointRows& rows = all.joints[at];
    const Eigen::VectorXd rigid = rows.X.leftCols(all.base) * pi;
    rows.set_column(all.plain + j, all.coulomb[at].cwiseProduct(rigid.cwiseAbs()));
  }
}

double sigma_of(double squares, const JointRows& rows) {
  const double floor = kSmallestSigma * kSmallestSigma * rows.yy;
  return std::sqrt(std::max({squares, floor, 1e-300}) / std::max(1.0, rows.count));
}

Solution solve(const StackedByJoint& all, const Columns& asked) {
  Columns columns;
  std::ranges::copy_if(asked, std::back_inserter(columns), [&](Eigen::Index k) {
    return std::ranges::any_of(all.joints,
                               [k](const JointRows& rows) { return rows.XX(k, k) > 0; });
  });
  const auto m = std::ssize(columns);
  Solution solution{{}, Eigen::VectorXd::Zero(all.size), Eigen::VectorXd::Zero(all.n()), m};
  for (int j = 0; j < all.n(); ++j) {
    const JointRows& rows = all.joints[static_cast<std::size_t>(j)];
    solution.sigma[j] = sigma_of(rows.yy, rows);
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
    const Eigen::MatrixXd covariance = invert(H, nullptr);
    solution.x(columns) = covariance * g;
    solution.error(columns) = covariance.diagonal().cwiseSqrt();
    for (int j = 0; j < all.n(); ++j) {
      const JointRows& rows = all.joints[static_cast<std::size_t>(j)];
      solution.sigma[j] = sigma_of(rows.squares(solution.x), rows);
    }
  }
  return solution;
}

Solution solve(const StackedByJoint& all, Eigen::Index first) {
  return solve(all, first_columns(first));
}

Eigen::VectorXd held_out_sigma(const StackedByJoint& all, const Columns& columns) {
  constexpr Eigen::Index kStretchesOfRows = 5;
  const auto n = static_cast<std::size_t>(all.n());
  std::vector<std::vector<JointRows>> stretches(kStretchesOfRows);
  for (std::size_t j = 0; j < n; ++j) {
    std::vector<Columns> chosen(kStretchesOfRows);
    const JointRows& rows = all.joints[j];
    for (std::size_t i = 0; i < rows.at.size(); ++i)
      chosen[static_cast<std::size_t>(rows.at[i] * kStretchesOfRows / all.rows)].push_back(
          static_cast<Eigen::Index>(i));
    for (std::size_t s = 0; s < stretches.size(); ++s)
      stretches[s].push_back(normal_equations(rows, chosen[s], all.size));
  }
  Eigen::VectorXd squares = Eigen::VectorXd::Zero(all.n());
  for (std::size_t s = 0; s < stretches.size(); ++s) {
    StackedByJoint others;
    others.size = all.size;
    for (std::size_t j = 0; j < n; ++j) {
      JointRows sum;
      for (std::size_t other = 0; other < stretches.size(); ++other) {
        if (other == s) continue;
        if (sum.XX.size() == 0)
          sum = stretches[other][j];
        else
          sum.add(stretches[other][j]);
      }
      others.joints.push_back(std::move(sum));
    }
    const Eigen::VectorXd x = solve(others, columns).x;
    for (std::size_t j = 0; j < n; ++j)
      squares[static_cast<Eigen::Index>(j)] += stretches[s][j].squares(x);
  }
  Eigen::VectorXd sigma(all.n());
  for (std::size_t j = 0; j < n; ++j)
    sigma[static_cast<Eigen::Index>(j)] =
        sigma_of(squares[static_cast<Eigen::Index>(j)], all.joints[j]);
  return sigma;
}

Eigen::VectorXd held_out_sigma(const StackedByJoint& all, Eigen::Index first) {
  return held_out_sigma(all, first_columns(first));
}

Eigen::MatrixXd jackknife_root(
    const StackedByJoint& all, const Eigen::VectorXd& x, const Eigen::VectorXd& sigma,
    const Eigen::MatrixXd& prior,
    const std::function<std::pair<Eigen::MatrixXd, Eigen::VectorXd>(int j)>& rows) {
  Eigen::MatrixXd X(all.rows, x.size());
  Eigen::VectorXd y(all.rows);
  Weighted solved;
  solved.x = x;
  solved.H = prior;
  solved.weight.resize(all.rows);
  for (int j = 0; j < all.n(); ++j) {
    const auto [X_j, y_j] = rows(j);
    const Columns& at = all.joints[static_cast<std::size_t>(j)].at;
    const double weight = std::pow(sigma[j], -2);
    X(at, Eigen::all) = X_j;
    y(at) = y_j;
    solved.weight(at).setConstant(weight);
    solved.H += weight * (X_j.transpose() * X_j);
  }
  return jackknife_root(X, y, solved, all.passage, prior);
}

Eigen::MatrixXd jackknife_root(const StackedByJoint& all, const Eigen::VectorXd& x,
                               const Eigen::VectorXd& sigma, const Eigen::MatrixXd& prior) {
  return jackknife_root(all, x, sigma, prior, [&](int j) {
    const JointRows& rows = all.joints[static_cast<std::size_t>(j)];
    return std::pair(rows.X, rows.y);
  });
}

double gain_of(const Eigen::VectorXd& sigma, const Eigen::VectorXd& less) {
  return 2 * (sigma.array() / less.array()).log().sum();
}

}  // namespace fricid::estimate
