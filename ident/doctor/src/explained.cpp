#include "explained.hpp"

#include <algorithm>
#include <cmath>

#include "fricid/base/eigen_instances.hpp"

namespace fricid::doctor {
namespace {

using data::RowMatrix;

// Least squares of y on the free columns and on those columns of `positive` whose coefficient is
// not negative in the best such solution.
Explained regress(const Eigen::MatrixXd& free, const Eigen::MatrixXd& positive,
                  const Eigen::VectorXd& y) {
  const double variance = (y.array() - y.mean()).square().sum();
  Explained best;
  if (!(variance > 0)) return best;
  const Eigen::Index f = free.cols(), p = positive.cols();
  Eigen::MatrixXd X(y.size(), f + p);
  X << free, positive;
  const Eigen::MatrixXd H = X.transpose() * X;
  const Eigen::VectorXd g = X.transpose() * y;
  for (int mask = 0; mask < 1 << p; ++mask) {
    std::vector<Eigen::Index> columns;
    for (Eigen::Index c = 0; c < f + p; ++c)
      if (c < f || (mask >> (c - f) & 1)) columns.push_back(c);
    const auto size = static_cast<Eigen::Index>(columns.size());
    Eigen::MatrixXd Hs(size, size);
    Eigen::VectorXd gs(size);
    for (Eigen::Index r = 0; r < size; ++r) {
      gs[r] = g[columns[static_cast<std::size_t>(r)]];
      for (Eigen::Index c = 0; c < size; ++c)
        Hs(r, c) = H(columns[static_cast<std::size_t>(r)], columns[static_cast<std::size_t>(c)]);
    }
    Hs.diagonal() *= 1 + 1e-9;
    const Eigen::VectorXd x = Hs.ldlt().solve(gs);
    bool allowed = x.allFinite();
    for (Eigen::Index i = f; i < size; ++i) allowed = allowed && x[i] >= 0;
    if (!allowed) continue;
    const double rest = y.squaredNorm() - 2 * x.dot(gs) + x.dot(Hs * x);
    const double unexplained = std::clamp(rest / variance, 1e-9, 1.0);
    const bool rigid = mask & 1;
    if (!rigid) best.friction_only = std::min(best.friction_only, unexplained);
    if (unexplained >= best.unexplained) continue;
    best.unexplained = unexplained;
    best.scale = rigid ? x[f] : 0;
    best.rigid = best.scale * positive.col(0).norm() / std::sqrt(static_cast<double>(y.size()));
  }
  return best;
}

}  // namespace

Judge::Judge(const dynamics::RobotModel* robot, int n) : robot_(robot), n_(n) {
  if (!robot_) return;
  ws_.emplace(*robot_);
  motors_.emplace(*robot_);
}

std::vector<Explained> Judge::explain(const Sight& s) {
  const RowMatrix nominal = robot_ ? torques(s, *robot_) : RowMatrix();
  const Motors motors = motors_of(s);
  std::vector<Explained> all;
  for (int j = 0; j < n_; ++j) all.push_back(explain(s, nominal, motors, j, {}));
  return all;
}

double Judge::unexplained_with_centre(const Sight& s, int joint) {
  dynamics::RobotModel moment = *robot_;
  RowMatrix centre(s.q.rows(), 3);
  for (int axis = 0; axis < 3; ++axis) {
    moment.pi.setZero();
    moment.pi[10 * joint + 1 + axis] = 1;
    centre.col(axis) = torques(s, moment).col(joint);
  }
  return explain(s, torques(s, *robot_), motors_of(s), joint, centre).unexplained;
}

Judge::Motors Judge::motors_of(const Sight& s) const {
  if (!robot_) return {s.v, s.a};
  return {motors_->to_motors(s.v), motors_->to_motors(s.a)};
}

// @param nominal  torque with a robot
// @param further  (T, ..) torques that are free
Explained Judge::explain(const Sight& s, const RowMatrix& nominal, const Motors& motors, int j,
                         const RowMatrix& further) const {
  const std::vector<int>& rows = s.rows[static_cast<std::size_t>(j)];
  const auto size = static_cast<Eigen::Index>(rows.size());
  const Eigen::Index of_gravity = robot_ ? 1 : 1 + 2 * n_;
  const RowMatrix declared = declared_torques(s, j);
  Eigen::MatrixXd free = Eigen::MatrixXd::Ones(size, of_gravity + declared.cols() + further.cols());
  const Eigen::RowVectorXd acting = motors_on(robot_, n_, j);
  const auto is_bare = [&](int m) {
    return robot_ && acting[m] != 0 && robot_->pi[robot_->armature_begin() + m] == 0;
  };
  const Eigen::Index of_motors = 3 * (acting.array() != 0).count();
  Eigen::Index bare = 0;
  for (int m = 0; m < n_; ++m) bare += is_bare(m);
  Eigen::MatrixXd positive(size, 1 + of_motors + (robot_ ? 1 + bare : 0));
  Eigen::VectorXd tau(size);
  for (Eigen::Index r = 0; r < size; ++r) {
    const int k = rows[static_cast<std::size_t>(r)];
    positive(r, 0) = robot_ ? nominal(k, j) : s.a(k, j);
    Eigen::Index next = 1;
    for (int m = 0; m < n_; ++m) {
      if (acting[m] == 0) continue;
      const double speed = motors.v(k, m), sign = speed > 0 ? 1 : -1;
      positive.row(r).segment<3>(next) << acting[m] * sign, acting[m] * speed,
          acting[m] * sign * std::sqrt(std::abs(speed));
      next += 3;
    }
    if (robot_) positive(r, next++) = (motors.v(k, j) > 0 ? 1 : -1) * std::abs(nominal(k, j));
    for (int m = 0; m < n_; ++m)
      if (is_bare(m)) positive(r, next++) = acting[m] * motors.a(k, m);
    for (int i = 0; !robot_ && i < n_; ++i) {
      free(r, 1 + 2 * i) = std::sin(s.q(k, i));
      free(r, 2 + 2 * i) = std::cos(s.q(k, i));
    }
    free.row(r).segment(of_gravity, declared.cols()) = declared.row(k);
    free.row(r).tail(further.cols()) = further.row(k);
    tau[r] = s.tau(k, j);
  }
  return size > 3 * (free.cols() + positive.cols()) ? regress(free, positive, tau) : Explained{};
}

RowMatrix Judge::declared_torques(const Sight& s, int j) const {
  std::vector<dynamics::LinearTorque> own;
  if (!robot_) return RowMatrix(s.q.rows(), 0);
  for (const dynamics::LinearTorque& torque : robot_->linear_torques)
    if (torque.joint == j && torque.shape != dynamics::LinearTorque::Shape::kConstant)
      own.push_back(torque);
  RowMatrix phi(s.q.rows(), std::ssize(own));
  for (std::size_t i = 0; i < own.size(); ++i)
    for (Eigen::Index k = 0; k < phi.rows(); ++k)
      phi(k, static_cast<Eigen::Index>(i)) = dynamics::shape_of(own[i], s.q(k, j));
  return phi;
}

RowMatrix Judge::torques(const Sight& s, const dynamics::RobotModel& robot) {
  const auto n = static_cast<std::size_t>(n_);
  const std::span<const double> pi{robot.pi.data(), static_cast<std::size_t>(robot.pi.size())};
  const RowMatrix q = motors_->to_motors(s.q), v = motors_->to_motors(s.v),
                  a = motors_->to_motors(s.a);
  RowMatrix tau(q.rows(), n_);
  for (Eigen::Index k = 0; k < q.rows(); ++k)
    dynamics::rnea<double>(robot, *ws_, pi, {q.row(k).data(), n}, {v.row(k).data(), n},
                           {a.row(k).data(), n}, {tau.row(k).data(), n});
  return motors_->torque_to_joints(tau);
}

double gain(const std::vector<Explained>& before, const std::vector<Explained>& after,
            double worse) {
  double sum = 0;
  for (std::size_t j = 0; j < before.size(); ++j) {
    const double log_ratio = std::log(before[j].unexplained / after[j].unexplained);
    if (log_ratio < -worse) return -1;
    sum += log_ratio;
  }
  return sum;
}

double log_unexplained(const std::vector<Explained>& explained) {
  double sum = 0;
  for (const Explained& e : explained) sum += std::log(e.unexplained);
  return sum;
}

}  // namespace fricid::doctor
