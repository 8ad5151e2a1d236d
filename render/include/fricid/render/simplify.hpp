// Fewer points, same picture.
#pragma once

#include <span>
#include <vector>

namespace fricid::render {

/// Indices of the points of a polyline that must stay so that no dropped point is farther than
/// `tolerance` from the line that replaces it; first and last stay. Recursive splitting at the
/// farthest point (Ramer, CGIP 1(3), 1972; Douglas & Peucker 1973).
/// @param x, y  finite, of equal length, in units of the picture
std::vector<std::size_t> simplified(std::span<const double> x, std::span<const double> y,
                                    double tolerance);

}  // namespace fricid::render
