#include "fricid/render/simplify.hpp"

#include <algorithm>
#include <utility>

namespace fricid::render {
namespace {

/// Square of the distance from a segment of a polyline.
struct Segment {
  double x, y, dx, dy, length2;

  double distance2(double at_x, double at_y) const {
    const double from_x = at_x - x, from_y = at_y - y;
    const double along = length2 > 0 ? (from_x * dx + from_y * dy) / length2 : 0;
    const double share = std::clamp(along, 0.0, 1.0);
    const double off_x = from_x - share * dx, off_y = from_y - share * dy;
    return off_x * off_x + off_y * off_y;
  }
};

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
    const double dx = x[b] - x[a], dy = y[b] - y[a];
    const Segment segment{x[a], y[a], dx, dy, dx * dx + dy * dy};
    double farthest = tolerance * tolerance;
    std::size_t split = a;
    for (std::size_t k = a + 1; k < b; ++k)
      if (const double off = segment.distance2(x[k], y[k]); off > farthest) {
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
