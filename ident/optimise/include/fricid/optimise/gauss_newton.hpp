// Gauss-Newton steps on coordinates of order one, with the matrix estimated from samples.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "fricid/optimise/box.hpp"

namespace fricid::optimise {

/// Weight of the square of every sample (a column): outliers count as if they were ten times as
/// long as the median sample. A single diverging rollout would dominate the matrix.
Eigen::VectorXf sample_weights(const Eigen::Ref<const Eigen::MatrixXf>& samples);

/// Whether each sample is more than `times` as long as the median one, or not finite.
std::vector<bool> outliers(const Eigen::Ref<const Eigen::MatrixXf>& samples, float times);

/// Stochastic Gauss-Newton with Levenberg's damping, momentum and a box. For a loss that is a mean
/// of squares r' W r / 2 with Jacobian J = dr/dx, a sample s = J' W^1/2 e with independent random
/// signs e costs one reverse sweep, and E[s s'] = J' W J is the Gauss-Newton matrix:
///
///     F = running mean of s s', weighted by kMemory against the new ones at every refresh
///     m = b m + (1 - b) g                                     g the gradient of a batch
///     x = clamp(x - clip(r (F + lambda diag F + mu I)^-1 m'))   m' = m / (1 - b^k)
///
/// Samples longer than ten times the median one of a refresh are shortened to it; where rounding
/// makes F indefinite, mu is raised. No coordinate moves by more than kLongest in a step; the whole
/// step is shortened then. Gradients longer than three times the running mean of their length are
/// shortened to it, as in Adam. O(size^2) memory in single precision and work per step, O(size^3)
/// per refresh.
/// @see Levenberg 1944; Martens, New insights and perspectives on the natural gradient method,
///      JMLR 21, 2020 (sampled curvature)
class GaussNewton {
 public:
  explicit GaussNewton(Eigen::Index size);

  /// Updates F with the finite ones of the samples (size x count) and factorises it, on up to
  /// `jobs` threads; the result does not depend on their number.
  void refresh(const Eigen::Ref<const Eigen::MatrixXf>& samples, int jobs);

  /// One step of relative length `rate` on x; a gradient that is not finite is skipped.
  /// @pre refresh was called
  /// @return false when it was skipped
  bool step(const Eigen::VectorXd& gradient, double rate, const Box& box, Eigen::VectorXd& x);

 private:
  Eigen::MatrixXf F_, factor_;  // lower triangles
  Eigen::VectorXd m_;
  double mass_ = 0, mean_length_ = 0;
  int k_ = 0;
};

}  // namespace fricid::optimise
