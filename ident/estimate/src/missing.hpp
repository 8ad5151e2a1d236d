// Missing values of a signal that must have one at every sample.
#pragma once

#include <algorithm>
#include <cmath>

#include "fricid/signals/matrix.hpp"

namespace fricid::estimate {

/// A missing value is that before it; at the start of a column its first, `none` if it has none.
inline void hold_missing(RowMatrix& x, double none) {
  for (Eigen::Index j = 0; j < x.cols(); ++j) {
    double held = none;
    for (Eigen::Index k = 0; k < x.rows(); ++k)
      if (std::isfinite(x(k, j))) {
        held = x(k, j);
        break;
      }
    for (Eigen::Index k = 0; k < x.rows(); ++k) {
      if (!std::isfinite(x(k, j))) x(k, j) = held;
      held = x(k, j);
    }
  }
}

}  // namespace fricid::estimate
