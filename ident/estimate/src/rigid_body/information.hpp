// Symmetric positive matrices, inverted through a unit diagonal: their units differ by orders.
#pragma once

#include <Eigen/Core>

namespace fricid::estimate {

/// S H S = V diag(values) V' with S = diag(scale).
struct ScaledEigen {
  Eigen::VectorXd scale;
  Eigen::VectorXd values;  ///< ascending
  Eigen::MatrixXd V;

  /// S V diag(of_values) V' S.
  Eigen::MatrixXd with_values(const Eigen::VectorXd& of_values) const;
};
/// In units in which `size` is one: scale = size^-1/2.
ScaledEigen scaled_eigen(const Eigen::MatrixXd& H, const Eigen::VectorXd& size);

/// Covariance of an information matrix; its condition number (root of that of H) if asked for. Of
/// what H has no information on the variance is about 1e12, whatever its unit.
Eigen::MatrixXd invert(const Eigen::MatrixXd& H, double* condition);

/// Inverse in the directions that H knows, 1e-9 of the largest at least, zero in the others.
/// @param size  of the columns, squared: of the diagonal
Eigen::MatrixXd pseudo_inverse(const Eigen::MatrixXd& H, const Eigen::VectorXd& size);

/// W with W' W = inverse of a covariance.
Eigen::MatrixXd inverse_root(const Eigen::MatrixXd& covariance);

}  // namespace fricid::estimate
