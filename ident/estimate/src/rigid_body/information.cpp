#include "rigid_body/information.hpp"

#include <cmath>

#include "fricid/base/eigen_instances.hpp"

namespace fricid::estimate {

namespace {

constexpr double kLeastEigenvalue = 1e-16;  // over the largest
constexpr double kScaleOfUnknown = 1e-2;    // of a variance of 1e12
constexpr double kNothing = 1e-9;           // eigenvalue over the largest

}  // namespace

Eigen::MatrixXd ScaledEigen::with_values(const Eigen::VectorXd& of_values) const {
  return scale.asDiagonal() * V * of_values.asDiagonal() * V.transpose() * scale.asDiagonal();
}

ScaledEigen scaled_eigen(const Eigen::MatrixXd& H, const Eigen::VectorXd& size) {
  const Eigen::VectorXd scale = size.cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(
      Eigen::MatrixXd(scale.asDiagonal() * H * scale.asDiagonal()));
  return {scale, eigen.eigenvalues(), eigen.eigenvectors()};
}

Eigen::MatrixXd invert(const Eigen::MatrixXd& H, double* condition) {
  if (H.size() == 0) {
    if (condition) *condition = 1;
    return H;
  }
  ScaledEigen eigen = scaled_eigen(H, H.diagonal());
  const double largest = eigen.values.maxCoeff();
  const Eigen::VectorXd values = eigen.values.cwiseMax(kLeastEigenvalue * largest);
  if (condition) *condition = std::sqrt(largest / values.minCoeff());
  eigen.scale = (H.diagonal().array() > 0).select(eigen.scale, kScaleOfUnknown).eval();
  return eigen.with_values(values.cwiseInverse());
}

Eigen::MatrixXd pseudo_inverse(const Eigen::MatrixXd& H, const Eigen::VectorXd& size) {
  const ScaledEigen eigen = scaled_eigen(H, size);
  Eigen::VectorXd values = eigen.values;
  const double least = kNothing * values.maxCoeff();
  for (double& value : values) value = value > least ? 1 / value : 0;
  return eigen.with_values(values);
}

Eigen::MatrixXd inverse_root(const Eigen::MatrixXd& covariance) {
  const ScaledEigen eigen = scaled_eigen(covariance, covariance.diagonal());
  const Eigen::VectorXd values = eigen.values.cwiseMax(kLeastEigenvalue * eigen.values.maxCoeff());
  return values.cwiseSqrt().cwiseInverse().asDiagonal() * eigen.V.transpose() *
         eigen.scale.asDiagonal();
}

}  // namespace fricid::estimate
