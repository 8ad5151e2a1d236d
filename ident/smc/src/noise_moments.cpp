#include "fricid/smc/noise_moments.hpp"

#include <cmath>

#include "fricid/base/eigen_instances.hpp"

namespace fricid::smc {

NoiseMoments::NoiseMoments(int n, int ny)
    : transition_(n, n), observation_(ny, ny), observations_(ny, ny) {
  clear();
}

void NoiseMoments::clear() {
  transition_.setZero();
  observation_.setZero();
  observations_.setZero();
  transitions_ = 0;
}

void NoiseMoments::add_transition(const Eigen::VectorXd& residual, double weight) {
  transition_.noalias() += weight * residual * residual.transpose();
  transitions_ += weight;
}

void NoiseMoments::add_observation(const RowMatrix& y, Eigen::Index t,
                                   const Eigen::VectorXd& predicted,
                                   const Eigen::MatrixXd* covariance, double weight) {
  for (Eigen::Index i = 0; i < y.cols(); ++i) {
    if (std::isnan(y(t, i))) continue;
    for (Eigen::Index j = 0; j < y.cols(); ++j) {
      if (std::isnan(y(t, j))) continue;
      const double square = (y(t, i) - predicted(i)) * (y(t, j) - predicted(j));
      observation_(i, j) += weight * (square + (covariance ? (*covariance)(i, j) : 0));
      observations_(i, j) += weight;
    }
  }
}

void NoiseMoments::add(const GaussianPath& path, const RowMatrix& y, const Eigen::MatrixXd& C) {
  Eigen::VectorXd residual;
  Eigen::MatrixXd covariance;
  for (std::size_t t = 0; t < path.smoothed.size(); ++t) {
    const Gaussian& x = path.smoothed[t];
    covariance = C * x.covariance * C.transpose();
    residual = C * x.mean;
    add_observation(y, static_cast<Eigen::Index>(t), residual, &covariance, 1);
    if (t + 1 == path.smoothed.size()) break;

    const Gaussian& next = path.smoothed[t + 1];
    const Eigen::MatrixXd& A = path.A[t];
    residual = next.mean - path.predicted[t + 1].mean - A * (x.mean - path.filtered[t].mean);
    add_transition(residual, 1);
    covariance = A * path.lag_one[t].transpose();
    transition_ +=
        next.covariance - covariance - covariance.transpose() + A * x.covariance * A.transpose();
  }
}

}  // namespace fricid::smc
