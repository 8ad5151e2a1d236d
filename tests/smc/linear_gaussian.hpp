// Oracles of the smc tests: random linear models and the joint normal distribution of all states.
#pragma once

#include <cstdint>

#include "fricid/base/rng.hpp"
#include "fricid/smc/model.hpp"

namespace fricid::smc::test {

/// Independent standard normal entries.
Eigen::MatrixXd random_matrix(Rng& rng, int rows, int columns);

/// Positive definite (n x n), eigenvalues at least 0.2 scale.
Eigen::MatrixXd random_covariance(Rng& rng, int n, double scale);

/// A stable model with n states of which max(1, n / 3) mixtures are observed.
LinearModel random_model(int n, std::uint64_t seed);

/// A position, a velocity: y = position.
LinearModel tracking_model();

struct Simulated {
  RowMatrix x, y;
};
Simulated simulate(const LinearModel& model, int T, std::uint64_t seed);

/// Every third channel of every fourth row, and the whole of row T / 2, is missing.
void punch_holes(RowMatrix& y);

/// log p(y) and the distribution of (x_0 .. x_{T-1}) given y from one linear system over all T n
/// numbers at once: no recursion in time.
struct DenseSolution {
  Eigen::VectorXd mean;        ///< (T n)
  Eigen::MatrixXd covariance;  ///< (T n x T n)
  double log_likelihood;
};
DenseSolution dense_solution(const LinearModel& model, const RowMatrix& y);

}  // namespace fricid::smc::test
