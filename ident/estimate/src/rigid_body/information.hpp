// Symmetric positive matrices, inverted through a unit diagonal: their units differ by orders.
#pragma once

#include <Eigen/Core>

namespace fricid::estimate {

/// Covariance of an information matrix; its condition number (root of that of H) if asked for. Of
/// what H has no information on the variance is about 1e12, whatever its unit.
Eigen::MatrixXd invert(const Eigen::MatrixXd& H, double* condition);

/// W with W' W = inverse of a covariance.
Eigen::MatrixXd inverse_root(const Eigen::MatrixXd& covariance);

}  // namespace fricid::estimate
