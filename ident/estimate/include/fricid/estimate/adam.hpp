// Adam on coordinates of order one.
#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

namespace fricid::estimate {

/// Adam (Kingma & Ba, ICLR 2015) with one step length per coordinate and a box:
///
///     m = b1 m + (1 - b1) g,   s = b2 s + (1 - b2) g^2,
///     x = clamp(x - rate_i r m' / (sqrt s' + eps)),   m' = m / (1 - b1^k), s' = s / (1 - b2^k).
///
/// Gradients longer than `clip` times the running mean of their length are shortened to it: one
/// window that falls over must not undo a hundred steps.
class Adam {
 public:
  explicit Adam(Eigen::Index size) : m_(Eigen::VectorXd::Zero(size)), s_(m_) {}

  /// One step of length `rate` on x; a gradient that is not finite is skipped.
  /// @return false when it was skipped
  bool step(const Eigen::VectorXd& gradient, double rate, const Eigen::VectorXd& rates,
            const Eigen::VectorXd& lower, const Eigen::VectorXd& upper, Eigen::VectorXd& x);

  /// m, s, the mean length and k: what a step depends on besides its arguments.
  std::vector<double> state() const;
  /// @param state  of an Adam of the same size
  void restore(std::span<const double> state);

 private:
  Eigen::VectorXd m_, s_;
  double mean_length_ = 0;
  int k_ = 0;
};

}  // namespace fricid::estimate
