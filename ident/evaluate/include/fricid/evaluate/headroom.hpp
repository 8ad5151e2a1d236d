// Headroom of a benchmark: from the best conventional model to the best possible one.
#pragma once

#include <cmath>
#include <limits>

namespace fricid::evaluate {

/// The reference errors of one horizon, mean squares of q [rad^2].
struct Headroom {
  double convention;     ///< of the best conventional model
  double best_possible;  ///< of the oracle, or the floor without one

  double ratio() const { return convention / best_possible; }

  /// log(convention / error) / log(convention / best possible): 0 as good as the convention, 1 as
  /// good as the best possible. NaN if the convention is no worse than the best possible.
  double closed(double error) const {
    if (!(convention > best_possible)) return std::numeric_limits<double>::quiet_NaN();
    return std::log(convention / error) / std::log(convention / best_possible);
  }
};

}  // namespace fricid::evaluate
