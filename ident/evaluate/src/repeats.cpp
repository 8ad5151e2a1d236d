#include "fricid/evaluate/repeats.hpp"

#include <cmath>
#include <limits>

namespace fricid::evaluate {
namespace {

constexpr double kLeft = 0.25;      // the motion has gone elsewhere
constexpr double kCameBack = 1e-3;  // the motion has come back
constexpr double kLagStep = 0.02;   // [s] of the first search
constexpr double kLongest = 300;    // [s]
constexpr int kSamples = 4000;      // looked at per lag

/// Mean of squared differences of a column with itself `lag` samples later; missing ones left out.
double squared_difference(ConstRowMatrix x, Eigen::Index j, int lag, int stride) {
  double sum = 0;
  int count = 0;
  for (Eigen::Index k = 0; k + lag < x.rows(); k += stride) {
    const double e = x(k + lag, j) - x(k, j);
    if (std::isnan(e)) continue;
    sum += e * e;
    ++count;
  }
  return sum / count;
}

double variance(ConstRowMatrix x, Eigen::Index j) {
  double sum = 0, squares = 0;
  int count = 0;
  for (Eigen::Index k = 0; k < x.rows(); ++k) {
    if (std::isnan(x(k, j))) continue;
    sum += x(k, j);
    squares += x(k, j) * x(k, j);
    ++count;
  }
  return squares / count - sum * sum / count / count;
}

/// How unlike a motion is to itself one lag later: 0 the same, 1 unrelated.
class Unlikeness {
 public:
  explicit Unlikeness(const data::Dataset& dataset) : q_(dataset.q) {
    constexpr double kMoves = 1e-3;  // [rad] sd of a joint that counts
    for (Eigen::Index j = 0; j < q_.cols(); ++j)
      if (const double v = variance(q_, j); v > kMoves * kMoves) moving_.emplace_back(j, v);
  }
  bool any() const { return !moving_.empty(); }
  double operator()(int lag, int stride) const {
    double sum = 0;
    for (const auto& [j, v] : moving_) sum += squared_difference(q_, j, lag, stride) / (2 * v);
    return sum / static_cast<double>(moving_.size());
  }

 private:
  ConstRowMatrix q_;
  std::vector<std::pair<Eigen::Index, double>> moving_;
};

/// Lag [samples], or 0.
int period_of(const data::Dataset& dataset) {
  const Unlikeness unlikeness(dataset);
  if (!unlikeness.any()) return 0;
  const auto samples = [&](double seconds) {
    return static_cast<int>(std::lround(seconds * dataset.rate_hz));
  };
  const int longest = std::min(dataset.length() / 2, samples(kLongest)),
            step = std::max(1, samples(kLagStep)),
            stride = std::max(1, dataset.length() / kSamples);
  bool left = false;
  for (int lag = step; lag <= longest; lag += step) {
    const double here = unlikeness(lag, stride);
    left |= here > kLeft;
    if (!left || here > kLeft / 2) continue;
    // Close to a return: its least lag lies within a step, or at a later one.
    const int last = std::min(longest, lag + step);
    int best = lag;
    double least = std::numeric_limits<double>::infinity();
    for (int near = lag - step + 1; near <= last; ++near)
      if (const double value = unlikeness(near, stride); value < least) {
        least = value;
        best = near;
      }
    if (least < kCameBack && (best < last || last == longest)) return best;
  }
  return 0;
}

}  // namespace

Repeats find_repeats(const data::Dataset& dataset) {
  const int period = period_of(dataset);
  if (period == 0) return {};
  Repeats repeats{period * dataset.dt(), {}, {}};
  for (Eigen::Index j = 0; j < dataset.n(); ++j) {
    repeats.q_sd.push_back(std::sqrt(squared_difference(dataset.q, j, period, 1) / 2));
    repeats.tau_sd.push_back(std::sqrt(squared_difference(dataset.tau, j, period, 1) / 2));
  }
  return repeats;
}

RowMatrix other_passage(ConstRowMatrix tau, int period) {
  RowMatrix other(tau.rows(), tau.cols());
  for (Eigen::Index k = 0; k < tau.rows(); ++k)
    other.row(k) = tau.row(k + period < tau.rows() ? k + period : k - period);
  return other;
}

}  // namespace fricid::evaluate
