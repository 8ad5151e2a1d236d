// Simplification of polylines.
#pragma once

#include <span>
#include <vector>

namespace fricid::render {

/// Indices of the points of a polyline to keep so that no dropped point is farther than `tolerance`
/// from the simplified line; first and last are kept. Recursive splitting at the farthest point
/// (Ramer, CGIP 1(3), 1972; Douglas & Peucker 1973).
/// @param x, y  finite, of equal length, in the same unit as `tolerance`
std::vector<std::size_t> simplified(std::span<const double> x, std::span<const double> y,
                                    double tolerance);

}  // namespace fricid::render
