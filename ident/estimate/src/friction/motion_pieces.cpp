#include "fricid/estimate/friction/motion_pieces.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace fricid::estimate {
namespace {

constexpr double kInterval = 0.1;  // [rad or m]
constexpr double kShare = 0.25;    // of the travel
constexpr double kLeast = 1e-3;    // [rad or m]; less is noise of a joint that stands still
constexpr double kSettled = 0.75;  // [s]
constexpr int kMostPieces = 16;    // of the longest range

struct Bounds {
  double low = std::numeric_limits<double>::infinity(), high = -low;
  void take(double x) {
    low = std::min(low, x);
    high = std::max(high, x);
  }
  double size() const { return high - low; }
};

/// Latest sample from which on the joint covers `interval` before `begin`, less `settled`; else 0.
int start_of_run_in(std::span<const double> q, int begin, double interval, int settled) {
  if (interval < kLeast) return 0;
  Bounds covered;
  int k = begin;
  covered.take(q[static_cast<std::size_t>(k)]);
  while (k > 0 && covered.size() < interval) covered.take(q[static_cast<std::size_t>(--k)]);
  return covered.size() < interval ? 0 : std::max(0, k - settled);
}

int last_multiple(int of, int below) { return below - below % of; }

int steps(const MotionPiece& piece) { return piece.end - piece.start; }

/// Steps of all groups of lanes, of pieces that are sorted by length.
long cost(std::span<const MotionPiece> pieces, int lanes) {
  long sum = 0;
  for (std::size_t i = 0; i < pieces.size(); i += static_cast<std::size_t>(lanes))
    sum += steps(pieces[i]);
  return sum;
}

}  // namespace

double run_in(std::span<const std::vector<double>> q, std::span<const SampleRange> ranges) {
  Bounds travel;
  for (std::size_t s = 0; s < ranges.size(); ++s)
    for (int k = ranges[s].begin; k < ranges[s].end; ++k)
      travel.take(q[s][static_cast<std::size_t>(k)]);
  return std::min(kInterval, kShare * travel.size());
}

std::vector<MotionPiece> cut_motion(std::span<const std::vector<double>> q,
                                    std::span<const SampleRange> ranges, double dt, int lanes,
                                    int grid) {
  int longest = 0;
  for (const SampleRange& range : ranges) longest = std::max(longest, range.size());
  const double interval = run_in(q, ranges);
  const int settled = static_cast<int>(std::lround(kSettled / dt));

  std::vector<MotionPiece> best;
  for (int count = 1; count <= std::min(kMostPieces, longest); ++count) {
    std::vector<MotionPiece> pieces;
    const int length = (longest + count - 1) / count;
    for (std::size_t s = 0; s < ranges.size(); ++s) {
      const SampleRange& range = ranges[s];
      const int parts = (range.size() + length - 1) / length;
      for (int i = 0; i < parts; ++i) {
        const auto bound = [&](int k) {
          const int sample = range.begin + k * range.size() / parts;
          return k == 0 || k == parts ? sample : std::max(range.begin, last_multiple(grid, sample));
        };
        const int begin = bound(i), end = bound(i + 1);
        if (begin == end) continue;
        const int start = start_of_run_in(q[s], begin, interval, settled);
        pieces.push_back({static_cast<int>(s), last_multiple(grid, start), begin, end});
      }
    }
    std::ranges::stable_sort(pieces, std::ranges::greater(), steps);
    if (best.empty() || cost(pieces, lanes) < cost(best, lanes)) best = std::move(pieces);
  }
  return best;
}

}  // namespace fricid::estimate
