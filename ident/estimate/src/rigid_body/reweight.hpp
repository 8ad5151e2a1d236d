// Weighted linear least squares of rows whose noise is known by group alone.
#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

namespace fricid::estimate {

struct Weighted {
  Eigen::VectorXd x;       ///< solution
  Eigen::MatrixXd H;       ///< information X' W X (+ prior)
  Eigen::VectorXd sigma;   ///< (groups)
  Eigen::VectorXd weight;  ///< (N) of each row in H
};

/// Solves tau = X x + e, e of group g ~ N(0, sigma_g^2), with the sigmas found by iteration.
/// @param group              (N) group of each row
/// @param robust             Huber weights beyond 2.5 sigma
/// @param prior_information  of x ~ N(prior_mean, inverse of it); zero: none
/// @param first_sigma        (groups) that the iteration begins with; empty: those of tau. It has
///                           more than one end: under a large sigma a wrong prior wins, and makes
///                           the residuals large
Weighted reweight(const Eigen::MatrixXd& X, const Eigen::VectorXd& tau,
                  const std::vector<int>& group, int groups, bool robust,
                  const Eigen::MatrixXd& prior_information, const Eigen::VectorXd& prior_mean,
                  const Eigen::VectorXd& first_sigma = {});

/// Root D (unknowns x ..) of the covariance D D' of the solution by the jackknife over passages,
/// the weights as they are: column b is sqrt((B - 1) / B) times the change of x without passage b,
///
///     -(H - X_b' W_b X_b)^-1 X_b' W_b e_b,
///
/// and, with P the prior information, the columns of H^-1 P^(1/2) follow. It holds where residuals
/// are correlated within a passage, as what friction's memory leaves of a rigid model, and where a
/// few passages hold all that is known of an unknown; H^-1 does not.
/// @param passage  (N) of each row, as of `TimeBlocks`
/// Source: MacKinnon, Nielsen & Webb, J. Econometrics 232 (2023), CV3.
Eigen::MatrixXd jackknife_root(const Eigen::MatrixXd& X, const Eigen::VectorXd& tau,
                               const Weighted& solved, std::span<const int> passage,
                               const Eigen::MatrixXd& prior_information);

/// What an error of tau that rows have in common makes of the solution: H^-1 X' W error.
/// @param error    (N)
/// @param inverse  of H
Eigen::VectorXd moved_by(const Eigen::VectorXd& error, const Eigen::MatrixXd& X,
                         const Weighted& solved, const Eigen::MatrixXd& inverse);

}  // namespace fricid::estimate
