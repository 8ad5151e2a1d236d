// Samples that two logs share, found through the rounding of an export.
#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "fricid/base/upper_median.hpp"
#include "fricid/data/log_part.hpp"

namespace fricid::data {
namespace {

constexpr Eigen::Index kStretch = 50, kShortestStretch = 8;  // rows that agree, at least
constexpr Eigen::Index kSeen = 20'000;       // rows of a long log that tell its noise and its steps
constexpr Eigen::Index kMostAnchors = 4000;  // stretches that are looked for

/// Standard deviation of what is no smooth motion, by fifth differences.
double noise_of(const RowMatrix& x, Eigen::Index j) {
  constexpr double kOfFifth = 0.6745 * 15.875;  // sqrt(252); median of a normal one
  const Eigen::Index every = std::max<Eigen::Index>(1, x.rows() / kSeen);
  std::vector<double> off;
  for (Eigen::Index k = 0; k + 5 < x.rows(); k += every)
    if (const double fifth = x(k + 5, j) - 5 * x(k + 4, j) + 10 * x(k + 3, j) - 10 * x(k + 2, j) +
                             5 * x(k + 1, j) - x(k, j);
        std::isfinite(fifth))
      off.push_back(std::abs(fifth));
  return upper_median(std::move(off)) / kOfFifth;
}

/// The step that all values are whole multiples of, but for a constant; `least` or so: none.
double step_of(const RowMatrix& x, Eigen::Index j, double least) {
  const Eigen::Index every = std::max<Eigen::Index>(1, x.rows() / kSeen);
  double step = 0, before = std::nan("");
  for (Eigen::Index k = 0; k < x.rows(); k += every) {
    if (!std::isfinite(x(k, j))) continue;
    // the greatest common divisor of all differences, after Euclid
    double rest = std::abs(x(k, j) - std::exchange(before, x(k, j)));
    while (rest > least) {
      const double divisor = rest;
      rest = std::abs(step - divisor * std::round(step / divisor));
      step = divisor;
    }
  }
  return step;
}

/// What each column may differ by in two exports of one recording: a fraction of its noise, the
/// last of six digits, or half of the coarser step where only one of them was rounded to it. Where
/// both have the steps of one sensor they are equal.
Eigen::RowVectorXd tolerances(const RowMatrix& a, const RowMatrix& b) {
  constexpr double kOfNoise = 0.3;                        // two measurements differ by 1.4 of it
  constexpr double kSixDigits = 5e-6, kLeastStep = 1e-6;  // of the largest value
  constexpr double kSame = 1e-3;                          // of a step
  Eigen::RowVectorXd out(a.cols());
  for (Eigen::Index j = 0; j < a.cols(); ++j) {
    const auto largest = [j](const RowMatrix& x) {
      double size = 0;
      for (const double value : x.col(j))
        if (std::isfinite(value)) size = std::max(size, std::abs(value));
      return size;
    };
    const double scale = std::max(largest(a), largest(b));
    out[j] = std::max(kOfNoise * std::min(noise_of(a, j), noise_of(b, j)), kSixDigits * scale);
    const double of_a = step_of(a, j, kLeastStep * scale), of_b = step_of(b, j, kLeastStep * scale);
    const double coarser = std::max(of_a, of_b), finer = std::min(of_a, of_b);
    if (coarser - finer > kSame * coarser)
      out[j] = std::max(out[j], (1 + kSame) * coarser / 2 + kSixDigits * scale);
  }
  return out;
}

/// Two logs of the same joints, row by row.
class Exports {
 public:
  Exports(const Dataset& a, const Dataset& b)
      : a_(a), b_(b), q_(tolerances(a.q, b.q)), tau_(tolerances(a.tau, b.tau)) {}

  /// Whether row i of the one is row k of the other; values that are missing may be any.
  bool agree(Eigen::Index i, Eigen::Index k) const {
    for (Eigen::Index j = 0; j < q_.size(); ++j)
      if (std::abs(a_.q(i, j) - b_.q(k, j)) > q_[j] ||
          std::abs(a_.tau(i, j) - b_.tau(k, j)) > tau_[j])
        return false;
    return true;
  }
  /// Whether `stretch` rows of the first log from row i on are known and a joint moves in them.
  bool tell(Eigen::Index i, Eigen::Index stretch) const {
    constexpr double kMoves = 4;  // tolerances
    const auto q = a_.q.middleRows(i, stretch);
    if (!q.allFinite() || !a_.tau.middleRows(i, stretch).allFinite()) return false;
    return ((q.row(stretch - 1) - q.row(0)).array().abs() > kMoves * q_.array()).any();
  }
  /// The joint whose position tells rows apart best.
  Eigen::Index best_joint() const {
    Eigen::Index best = 0;
    double most = -1;
    for (Eigen::Index j = 0; j < q_.size(); ++j) {
      double low = std::numeric_limits<double>::infinity(), high = -low;
      for (const double q : a_.q.col(j))
        if (std::isfinite(q)) low = std::min(low, q), high = std::max(high, q);
      if (const double tells = (high - low) / q_[j]; tells > most) most = tells, best = j;
    }
    return best;
  }
  double tolerance(Eigen::Index joint) const { return q_[joint]; }

 private:
  const Dataset &a_, &b_;
  Eigen::RowVectorXd q_, tau_;  // that values of a column may differ by
};

}  // namespace

// Stretches of the one log, spread over it, are looked for in all of the other by the position of a
// joint; one that is found is followed to both sides.
int samples_in_common(const Dataset& dataset, const Dataset& other) {
  const Eigen::Index own = dataset.q.rows(), others = other.q.rows();
  const Eigen::Index stretch = std::min({kStretch, own, others});
  if (stretch < kShortestStretch || dataset.n() == 0) return 0;
  const Exports exports(dataset, other);
  const Eigen::Index joint = exports.best_joint();
  const double tolerance = exports.tolerance(joint);

  std::vector<std::pair<double, Eigen::Index>> anchors;  // position and row
  const Eigen::Index every = std::max(stretch / 2, own / kMostAnchors);
  for (Eigen::Index i = 0; i + stretch <= own; i += every)
    if (exports.tell(i, stretch)) anchors.emplace_back(dataset.q(i, joint), i);
  std::ranges::sort(anchors);

  std::vector<char> is_common(static_cast<std::size_t>(own), 0);
  const auto follow = [&](Eigen::Index i, Eigen::Index k) {
    Eigen::Index before = 0, length = 0;
    while (i + length < own && k + length < others && exports.agree(i + length, k + length))
      ++length;
    if (length < stretch) return;
    while (before < std::min(i, k) && exports.agree(i - before - 1, k - before - 1)) ++before;
    std::fill_n(is_common.begin() + (i - before), before + length, 1);
  };
  for (Eigen::Index k = 0; k + stretch <= others; ++k) {
    const double q = other.q(k, joint);
    auto anchor = std::ranges::lower_bound(anchors, std::pair{q - tolerance, Eigen::Index{0}});
    for (; anchor != anchors.end() && anchor->first <= q + tolerance; ++anchor)
      if (const Eigen::Index i = anchor->second; is_common[static_cast<std::size_t>(i)] == 0)
        follow(i, k);
  }
  return static_cast<int>(std::ranges::count(is_common, 1));
}

}  // namespace fricid::data
