#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "fricid/smc/kalman.hpp"
#include "fricid/smc/model.hpp"

namespace fricid::smc {

/// Expected squares of the noise given all observations, from which the M-step takes Q and R:
///     Q = sum_t E[(x_{t+1} - f_t(x_t)) (x_{t+1} - f_t(x_t))'] / number of transitions
///     R = sum_t E[(y_t - C x_t) (y_t - C x_t)'] / number of observations
/// Sequences add up. Where channels are missing, an entry of R averages the steps that have both of
/// its channels: the maximiser when R is diagonal or all is present.
/// @see Shumway & Stoffer, J. Time Series Analysis 3, 1982
class NoiseMoments {
 public:
  NoiseMoments(int state_size, int observation_size);

  void clear();
  /// Adds a smoothed Gaussian path; of a linearised model, with f linearised as the filter had it.
  void add(const GaussianPath& path, const RowMatrix& y, const Eigen::MatrixXd& C);
  /// Adds the mean over sampled paths (T x n each).
  template <StateSpaceModel M>
  void add(M& model, const RowMatrix& y, std::span<const RowMatrix> paths);

  Eigen::MatrixXd Q() const { return transition_ / transitions_; }
  Eigen::MatrixXd R() const { return observation_.cwiseQuotient(observations_); }

 private:
  void add_transition(const Eigen::VectorXd& residual, double weight);
  void add_observation(const RowMatrix& y, Eigen::Index t, const Eigen::VectorXd& predicted,
                       const Eigen::MatrixXd* covariance, double weight);

  Eigen::MatrixXd transition_, observation_, observations_;
  double transitions_ = 0;
};

template <StateSpaceModel M>
void NoiseMoments::add(M& model, const RowMatrix& y, std::span<const RowMatrix> paths) {
  const double weight = 1 / static_cast<double>(paths.size());
  const auto n = static_cast<std::size_t>(model.state_size());
  std::vector<double> f(n);
  Eigen::VectorXd x(model.state_size()), predicted(model.observation_size());
  for (const RowMatrix& path : paths) {
    for (Eigen::Index t = 0; t < path.rows(); ++t) {
      x = path.row(t);
      predicted.noalias() = model.C() * x;
      add_observation(y, t, predicted, nullptr, weight);
      if (t + 1 == path.rows()) break;
      std::copy_n(x.data(), n, f.data());
      model.transition(static_cast<int>(t), std::span<double>(f));
      const Eigen::Map<const Eigen::VectorXd> image(f.data(), x.size());
      x = path.row(t + 1).transpose() - image;
      add_transition(x, weight);
    }
  }
}

}  // namespace fricid::smc
