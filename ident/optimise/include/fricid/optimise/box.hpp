// Bounds of coordinates.
#pragma once

#include <Eigen/Core>

namespace fricid::optimise {

/// Closed bounds of every coordinate, infinite where there is none.
struct Box {
  Eigen::VectorXd lower, upper;

  Eigen::VectorXd clamp(const Eigen::VectorXd& c) const {
    return c.cwiseMax(lower).cwiseMin(upper);
  }
};

}  // namespace fricid::optimise
