// Weighted linear least squares of rows whose noise is known by group alone.
#pragma once

#include <Eigen/Core>
#include <vector>

namespace fricid::estimate {

struct Weighted {
  Eigen::VectorXd x;      ///< solution
  Eigen::MatrixXd H;      ///< information X' W X (+ prior)
  Eigen::VectorXd sigma;  ///< (groups)
};

/// Solves tau = X x + e, e of group g ~ N(0, sigma_g^2), with the sigmas found by iteration.
/// @param group              (N) group of each row
/// @param robust             Huber weights beyond 2.5 sigma
/// @param prior_information  of x ~ N(prior_mean, inverse of it); zero: none
Weighted reweight(const Eigen::MatrixXd& X, const Eigen::VectorXd& tau,
                  const std::vector<int>& group, int groups, bool robust,
                  const Eigen::MatrixXd& prior_information, const Eigen::VectorXd& prior_mean);

}  // namespace fricid::estimate
