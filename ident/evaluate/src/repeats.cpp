#include "fricid/evaluate/repeats.hpp"

#include <cmath>

#include "fricid/signals/periods.hpp"

namespace fricid::evaluate {
namespace {

constexpr double kCameBack = 1e-3;  // the motion has come back
constexpr signals::PeriodRange kRange{.shortest_s = 0, .longest_s = 300, .least_count = 2};

/// Mean of squared differences of a column with itself `lag` samples later; missing ones left out.
double squared_difference(ConstRowMatrix x, Eigen::Index j, int lag) {
  double sum = 0;
  int count = 0;
  for (Eigen::Index k = 0; k + lag < x.rows(); ++k) {
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
double unlikeness(ConstRowMatrix q, int lag) {
  constexpr double kMoves = 1e-3;  // [rad] sd of a joint that counts
  double sum = 0;
  int moving = 0;
  for (Eigen::Index j = 0; j < q.cols(); ++j)
    if (const double v = variance(q, j); v > kMoves * kMoves) {
      sum += squared_difference(q, j, lag) / (2 * v);
      ++moving;
    }
  return sum / moving;
}

}  // namespace

Repeats find_repeats(const data::Dataset& dataset) {
  const int period = signals::period_of(dataset.q, dataset.dt(), kRange);
  if (period == 0 || !(unlikeness(dataset.q, period) < kCameBack)) return {};
  Repeats repeats{period * dataset.dt(), {}, {}};
  for (Eigen::Index j = 0; j < dataset.n(); ++j) {
    repeats.q_sd.push_back(std::sqrt(squared_difference(dataset.q, j, period) / 2));
    repeats.tau_sd.push_back(std::sqrt(squared_difference(dataset.tau, j, period) / 2));
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
