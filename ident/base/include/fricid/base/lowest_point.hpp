// The lowest point of a sampled curve.
#pragma once

#include <algorithm>
#include <span>

namespace fricid {

/// Where a curve with values y at 0, 1, .. is lowest: the vertex of the parabola through its lowest
/// value and the neighbours; an end where that is the lowest.
/// @pre y is not empty
inline double lowest_point(std::span<const double> y) {
  const auto at = static_cast<std::size_t>(std::ranges::min_element(y) - y.begin());
  if (at == 0 || at + 1 == y.size()) return static_cast<double>(at);
  const double bend = y[at - 1] - 2 * y[at] + y[at + 1];
  return static_cast<double>(at) + (bend > 0 ? 0.5 * (y[at - 1] - y[at + 1]) / bend : 0);
}

}  // namespace fricid
