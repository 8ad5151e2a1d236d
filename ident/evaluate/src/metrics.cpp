#include "fricid/evaluate/metrics.hpp"
#include "fricid/base/not_finite.hpp"

#include <cmath>

namespace fricid::evaluate {
namespace {

constexpr double kPreslidingSpeed = 0.05;     // [rad/s] of a turning joint
constexpr double kPreslidingTravel = 0.005;   // [rad] of a turning joint
constexpr double kReversalHalfWindow = 0.05;  // [s]

/// Running mean of e^2 and |e|; NaN when empty.
struct Mean {
  double squares = 0, magnitudes = 0;
  int count = 0;
  void add(double error) {
    if (std::isnan(error)) return;
    squares += error * error;
    magnitudes += std::abs(error);
    ++count;
  }
  double mse() const { return count ? squares / count : kNan; }
  double mae() const { return count ? magnitudes / count : kNan; }
  double rmse() const { return std::sqrt(mse()); }
};

double average(const std::vector<double>& values) {
  double sum = 0;
  for (const double value : values) sum += value;
  return sum / static_cast<double>(values.size());
}

/// Errors of one signal per joint over rows 0 .. steps.
void pool(const RowMatrix& x, const RowMatrix& reference, int begin, int steps,
          std::vector<double>& mse, std::vector<double>& mae) {
  for (Eigen::Index j = 0; j < x.cols(); ++j) {
    Mean errors;
    if (steps < x.rows())
      for (int k = 0; k <= steps; ++k) errors.add(x(k, j) - reference(begin + k, j));
    mse.push_back(errors.mse());
    mae.push_back(errors.mae());
  }
}

/// Regime of every sample of one joint.
struct Regimes {
  std::vector<bool> presliding, reversal;
};

Regimes regimes_of(ConstRowMatrix q, ConstRowMatrix v, Eigen::Index j, double dt, double scale) {
  const auto T = static_cast<std::size_t>(v.rows());
  Regimes regimes{std::vector<bool>(T), std::vector<bool>(T)};
  const auto window = static_cast<std::size_t>(std::lround(kReversalHalfWindow / dt));
  double direction = 0, turned_at = q(0, j);
  for (std::size_t k = 0; k < T; ++k) {
    const auto row = static_cast<Eigen::Index>(k);
    const double speed = v(row, j);
    if (speed * direction < 0) {
      turned_at = q(row, j);
      for (std::size_t i = k - std::min(k, window); i < std::min(T, k + window); ++i)
        regimes.reversal[i] = true;
    }
    if (speed != 0) direction = speed;
    regimes.presliding[k] = std::abs(speed) < scale * kPreslidingSpeed ||
                            std::abs(q(row, j) - turned_at) < scale * kPreslidingTravel;
  }
  return regimes;
}

}  // namespace

Eigen::VectorXd mean_absolute_error(ConstRowMatrix q, ConstRowMatrix reference) {
  Eigen::VectorXd error(q.rows());
  for (Eigen::Index k = 0; k < q.rows(); ++k) {
    double sum = 0;
    for (Eigen::Index j = 0; j < q.cols(); ++j) sum += std::abs(q(k, j) - reference(k, j));
    error[k] = sum / static_cast<double>(q.cols());
  }
  return error;
}

void HorizonErrors::add(HorizonError error) {
  q_mse.push_back(error.q_mse);
  q_mae.push_back(error.q_mae);
  v_mse.push_back(error.v_mse);
  v_mae.push_back(error.v_mae);
  q_mse_joint.push_back(std::move(error.q_mse_joint));
  q_mae_joint.push_back(std::move(error.q_mae_joint));
  v_mse_joint.push_back(std::move(error.v_mse_joint));
  v_mae_joint.push_back(std::move(error.v_mae_joint));
}

HorizonError horizon_error(const Rollout& rollout, const Trajectory& trajectory, int steps) {
  HorizonError error{};
  const int begin = rollout.start.begin;
  pool(rollout.q, trajectory.scored_q(), begin, steps, error.q_mse_joint, error.q_mae_joint);
  pool(rollout.v, trajectory.scored_v(), begin, steps, error.v_mse_joint, error.v_mae_joint);
  error.q_mse = average(error.q_mse_joint);
  error.q_mae = average(error.q_mae_joint);
  error.v_mse = average(error.v_mse_joint);
  error.v_mae = average(error.v_mae_joint);
  return error;
}

RegimeError regime_error(ConstRowMatrix error, ConstRowMatrix q, ConstRowMatrix v, double dt,
                         int begin, std::span<const dynamics::Joint> joints) {
  RegimeError rmse;
  for (Eigen::Index j = 0; j < error.cols(); ++j) {
    const Regimes regimes =
        regimes_of(q, v, j, dt, dynamics::travel_scale(joints[static_cast<std::size_t>(j)]));
    Mean all, presliding, reversal, sliding;
    for (Eigen::Index i = 0; i < error.rows(); ++i) {
      const double e = error(i, j);
      const auto k = static_cast<std::size_t>(begin + i);
      all.add(e);
      if (regimes.presliding[k]) presliding.add(e);
      if (regimes.reversal[k]) reversal.add(e);
      if (!regimes.presliding[k] && !regimes.reversal[k]) sliding.add(e);
    }
    rmse.all.push_back(all.rmse());
    rmse.presliding.push_back(presliding.rmse());
    rmse.reversal.push_back(reversal.rmse());
    rmse.sliding.push_back(sliding.rmse());
  }
  return rmse;
}

RegimeError friction_error(ConstRowMatrix tau_f, const Trajectory& trajectory, int begin,
                           std::span<const dynamics::Joint> joints) {
  const Reference& truth = *trajectory.truth;
  const RowMatrix error = tau_f - truth.tau_f.middleRows(begin, tau_f.rows());
  return regime_error(error, truth.q, truth.v, trajectory.data.dt(), begin, joints);
}

std::vector<double> friction_rms(const Trajectory& trajectory) {
  std::vector<double> rms;
  const RowMatrix& tau_f = trajectory.truth->tau_f;
  for (Eigen::Index j = 0; j < tau_f.cols(); ++j)
    rms.push_back(std::sqrt(tau_f.col(j).squaredNorm() / static_cast<double>(tau_f.rows())));
  return rms;
}

}  // namespace fricid::evaluate
