// A robust middle of some numbers.
#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

namespace fricid {

/// The upper of the two middle values, of an odd number the middle one; 0 of none.
/// @pre none is NaN
inline double upper_median(std::vector<double> x) {
  if (x.empty()) return 0;
  const auto middle = x.begin() + static_cast<std::ptrdiff_t>(x.size() / 2);
  std::nth_element(x.begin(), middle, x.end());
  return *middle;
}

}  // namespace fricid
