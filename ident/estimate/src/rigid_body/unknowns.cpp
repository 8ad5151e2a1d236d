#include "rigid_body/unknowns.hpp"

#include <cmath>

#include "fricid/dynamics/base_parameters.hpp"
#include "rigid_body/inertia_prior.hpp"

namespace fricid::estimate {
namespace {

constexpr double kOffset = 0.1;  // sd of an offset over the torque's rms, under a prior

// See `Unknowns::shares`.
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

/// Precision (p + columns of friction) of linear friction and offsets under a prior. In a log whose
/// joints slide in one direction the sum of Coulomb friction and offset is known, not its parts:
/// the offset is small, friction within the torque. Offsets with a stated width keep it. Growth of
/// friction has its own prior.
/// @param shares  see `Unknowns`
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

}  // namespace

Eigen::MatrixXd pick(const Eigen::MatrixXd& full, const std::vector<int>& columns) {
  Eigen::MatrixXd out(full.rows(), static_cast<Eigen::Index>(columns.size()));
  for (std::size_t i = 0; i < columns.size(); ++i)
    out.col(static_cast<Eigen::Index>(i)) = full.col(columns[i]);
  return out;
}

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

}  // namespace fricid::estimate
