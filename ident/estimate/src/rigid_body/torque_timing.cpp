#include "fricid/estimate/rigid_body/torque_timing.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <vector>

#include "fricid/base/eigen_instances.hpp"
#include "fricid/data/dataset.hpp"
#include "fricid/dynamics/base_parameters.hpp"
#include "rigid_body/regression.hpp"
#include "rigid_body/regression_start.hpp"
#include "rigid_body/reweight.hpp"

namespace fricid::estimate {
namespace {

constexpr Eigen::Index kRowsPerUnknown = 10;

/// (N) Change per sample of the torque that a fit predicts: measured, its noise would hide a delay.
Eigen::VectorXd torque_rates(const dynamics::RobotModel& robot, const RigidBodyFit& fit,
                             std::span<const signals::Recording> recordings,
                             const Regression& data) {
  std::vector<RowMatrix> predicted;
  for (const signals::Recording& r : recordings)
    predicted.push_back(rigid_body_torque(robot, fit.pi, r) +
                        RowMatrix(r.narrow.v * fit.Fv.asDiagonal()));
  Eigen::VectorXd rates(std::ssize(data.sample));
  for (Eigen::Index r = 0; r < rates.size(); ++r) {
    const auto at = static_cast<std::size_t>(r);
    const RowMatrix& tau = predicted[static_cast<std::size_t>(data.sequence[at])];
    const Eigen::Index k = data.sample[at], j = data.joint[at];
    const Eigen::Index from = std::max<Eigen::Index>(0, k - 1),
                       to = std::min<Eigen::Index>(tau.rows() - 1, k + 1);
    rates[r] = (tau(to, j) - tau(from, j)) / static_cast<double>(to - from);
  }
  return rates;
}

}  // namespace

bool TorqueTiming::is_at_samples() const {
  constexpr double kBetween = data::kMeasuredLater / 2, kCertain = 3, kLeastGain = 0.1;
  return gain > kLeastGain &&
         std::abs(delay - data::kMeasuredLater) < kBetween - kCertain * standard_error;
}

double TorqueTiming::likelihood_at_samples(double dt) const {
  constexpr double kLag = 1e-3;  // [s]
  const double variance = std::pow(standard_error, 2) + std::pow(kLag / dt, 2);
  const double log_odds =
      (std::pow(delay, 2) - std::pow(delay - data::kMeasuredLater, 2)) / (2 * variance);
  return 1 / (1 + std::exp(-log_odds));
}

std::optional<TorqueTiming> torque_timing(const dynamics::RobotModel& robot,
                                          std::span<const signals::Recording> recordings,
                                          const RigidBodyOptions& options) {
  const RegressionStart start = start_of_regression(robot, options);
  RigidBodyFit counts;
  const Regression data = stack(start.robot, recordings, start.options, nullptr, counts);
  std::vector<int> columns = dynamics::base_parameters(start.robot).columns;
  std::ranges::copy(excited_friction(start.robot, data), std::back_inserter(columns));
  const auto size = std::ssize(columns);
  if (data.rows.rows() < kRowsPerUnknown * size) return {};
  const RigidBodyFit fit = rigid_body_least_squares(start.robot, recordings, start.options);
  if (fit.Fv.size() != robot.n()) return {};

  const auto solved = [&](const Eigen::MatrixXd& X) {
    return reweight(X, data.tau, data.joint, robot.n(), options.robust,
                    Eigen::MatrixXd::Zero(X.cols(), X.cols()), Eigen::VectorXd::Zero(X.cols()));
  };
  Eigen::MatrixXd X(data.rows.rows(), size + 1);
  X << data.rows(Eigen::all, columns), -torque_rates(start.robot, fit, recordings, data);
  const Weighted without = solved(X.leftCols(size)), with = solved(X);
  const Eigen::MatrixXd root =
      jackknife_root(X, data.tau, with, data.passage, Eigen::MatrixXd::Zero(size + 1, size + 1));
  const double delay = with.x[size], error = root.row(size).norm();
  if (!std::isfinite(delay) || !std::isfinite(error)) return {};
  // of a joint that rests there is no residual
  const Eigen::ArrayXd gains = 2 * (without.sigma.array() / with.sigma.array()).log();
  return TorqueTiming{delay, error, gains.isFinite().select(gains, 0).sum()};
}

}  // namespace fricid::estimate
