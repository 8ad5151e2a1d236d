#include "rigid_body/information.hpp"

#include <cmath>

#include "fricid/base/eigen_instances.hpp"

namespace fricid::estimate {

namespace {

constexpr double kLeastEigenvalue = 1e-16;  // over the largest
constexpr double kScaleOfUnknown = 1e-2;    // of a variance of 1e12

}  // namespace

Eigen::MatrixXd invert(const Eigen::MatrixXd& H, double* condition) {
  if (H.size() == 0) {
    if (condition) *condition = 1;
    return H;
  }
  Eigen::VectorXd scale = H.diagonal().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(
      Eigen::MatrixXd(scale.asDiagonal() * H * scale.asDiagonal()));
  const double largest = eigen.eigenvalues().maxCoeff();
  const Eigen::VectorXd values = eigen.eigenvalues().cwiseMax(kLeastEigenvalue * largest);
  if (condition) *condition = std::sqrt(largest / values.minCoeff());
  scale = (H.diagonal().array() > 0).select(scale, kScaleOfUnknown).eval();
  return scale.asDiagonal() * eigen.eigenvectors() * values.cwiseInverse().asDiagonal() *
         eigen.eigenvectors().transpose() * scale.asDiagonal();
}

Eigen::MatrixXd inverse_root(const Eigen::MatrixXd& covariance) {
  const Eigen::VectorXd scale = covariance.diagonal().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(
      Eigen::MatrixXd(scale.asDiagonal() * covariance * scale.asDiagonal()));
  const Eigen::VectorXd values =
      eigen.eigenvalues().cwiseMax(kLeastEigenvalue * eigen.eigenvalues().maxCoeff());
  return values.cwiseSqrt().cwiseInverse().asDiagonal() * eigen.eigenvectors().transpose() *
         scale.asDiagonal();
}

}  // namespace fricid::estimate
