#include "simplify.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace fricid::render {
namespace {

/// Distance of point k from the segment between points a and b.
double distance(std::span<const double> x, std::span<const double> y, std::size_t k, std::size_t a,
                std::size_t b) {
  const double dx = x[b] - x[a], dy = y[b] - y[a];
  const double length2 = dx * dx + dy * dy;
  const double along = length2 > 0 ? ((x[k] - x[a]) * dx + (y[k] - y[a]) * dy) / length2 : 0;
  const double share = std::clamp(along, 0.0, 1.0);
  return std::hypot(x[k] - x[a] - share * dx, y[k] - y[a] - share * dy);
}

}  // namespace

std::vector<std::size_t> simplified(std::span<const double> x, std::span<const double> y,
                                    double tolerance) {
  const std::size_t n = x.size();
  std::vector<bool> stays(n, false);
  std::vector<std::pair<std::size_t, std::size_t>> open;
  if (n > 0) {
    stays.front() = stays.back() = true;
    open.emplace_back(0, n - 1);
  }
  while (!open.empty()) {
    const auto [a, b] = open.back();
    open.pop_back();
    double farthest = tolerance;
    std::size_t split = a;
    for (std::size_t k = a + 1; k < b; ++k)
      if (const double off = distance(x, y, k, a, b); off > farthest) {
        farthest = off;
        split = k;
      }
    if (split == a) continue;
    stays[split] = true;
    open.emplace_back(a, split);
    open.emplace_back(split, b);
  }
  std::vector<std::size_t> kept;
  for (std::size_t k = 0; k < n; ++k)
    if (stays[k]) kept.push_back(k);
  return kept;
}

}  // namespace fricid::render
