// Adam on coordinates of order one.
#pragma once

#include <Eigen/Core>

#include "fricid/optimise/box.hpp"

namespace fricid::optimise {

/// Adam (Kingma & Ba, ICLR 2015) with one step length per coordinate and a box:
///
///     m = b1 m + (1 - b1) g,   s = b2 s + (1 - b2) g^2,
///     x = clamp(x - rate_i r m' / (sqrt s' + eps)),   m' = m / (1 - b1^k), s' = s / (1 - b2^k).
///
/// Gradients longer than `clip` times the running mean of their length are shortened to it, so that
/// one diverging window does not undo many steps.
class Adam {
 public:
  explicit Adam(Eigen::Index size) : m_(Eigen::VectorXd::Zero(size)), s_(m_) {}

  /// One step of length `rate` on x; a gradient that is not finite is skipped.
  /// @return false when it was skipped
  bool step(const Eigen::VectorXd& gradient, double rate, const Eigen::VectorXd& rates,
            const Box& box, Eigen::VectorXd& x);

  /// State of the optimiser, for checkpoints.
  template <class Archive>
  void visit(Archive& archive) {
    archive("adam.m", m_);
    archive("adam.s", s_);
    archive("adam.mean_length", mean_length_);
    archive("adam.k", k_);
  }

 private:
  Eigen::VectorXd m_, s_;
  double mean_length_ = 0;
  int k_ = 0;
};

}  // namespace fricid::optimise
