// Narrower bounds of single parameters.
#pragma once

#include <cstddef>

namespace fricid::estimate {

/// Bounds of one parameter of friction inside those of the law table; equal ones hold it.
struct Limit {
  std::size_t parameter;  ///< index in theta
  double lower, upper;
};

}  // namespace fricid::estimate
