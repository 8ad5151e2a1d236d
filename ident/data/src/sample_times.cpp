#include "fricid/data/sample_times.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <vector>

#include "fricid/base/upper_median.hpp"

namespace fricid::data {
namespace {

constexpr double kDrift = 5e-4;        // of the period
constexpr Eigen::Index kBlocks = 10;   // of the log, for drift
constexpr double kCertain = 6;         // standard errors
constexpr double kSlight = 0.03;       // of the period, rms
constexpr double kSlightAtMost = 0.2;  // of the period

// Times of the rows that rise, each real gap closed to one period.
Eigen::VectorXd without_gaps(const Eigen::VectorXd& t, double rate_hz) {
  Eigen::VectorXd s = t(rising_rows(t));
  const std::vector<int> lost = lost_before(s, rate_hz);
  double gaps = 0, before = s[0];
  for (Eigen::Index k = 1; k < s.size(); ++k) {
    if (lost[static_cast<std::size_t>(k)] > 0) gaps += s[k] - before - 1 / rate_hz;
    before = s[k];
    s[k] -= gaps;
  }
  return s;
}

// Numbers of `count` rows about their middle, from -1/2 to 1/2.
Eigen::VectorXd rows_about_middle(Eigen::Index count) {
  return Eigen::VectorXd::LinSpaced(count, 0, 1).array() - 0.5;
}

// Time from the first to the last row along the line through all stamps.
double length_of_line(const Eigen::VectorXd& t) {
  const Eigen::VectorXd row = rows_about_middle(t.size());
  return row.dot(t) / row.squaredNorm();
}

// Period of rows whose stamps are coarser than they: a row with a new stamp was taken within one
// period of it, so that a line through those rows is off by no more than that over all of them.
// 0 where they span fewer than `kEnough` rows, which leaves more than a per cent open.
double period_between_steps(const Eigen::VectorXd& t) {
  constexpr Eigen::Index kEnough = 100;
  std::vector<double> rows, stamps;
  for (Eigen::Index k = 1; k < t.size(); ++k)
    if (t[k] > t[k - 1]) {
      rows.push_back(static_cast<double>(k));
      stamps.push_back(t[k]);
    }
  if (rows.size() < 2 || rows.back() - rows.front() < kEnough) return 0;
  Eigen::ArrayXd row = Eigen::ArrayXd::Map(rows.data(), std::ssize(rows));
  row -= row.mean();
  return (row * Eigen::ArrayXd::Map(stamps.data(), std::ssize(stamps))).sum() / row.square().sum();
}

// Mean period of rows [first, first + count): from the usual stamp of their first half to that of
// their second, so that no single stamp counts, and none is wrong by what all are late.
double usual_period(const Eigen::VectorXd& s, Eigen::Index first, Eigen::Index count,
                    double period) {
  const Eigen::Index half = count / 2;
  const auto usual = [&](Eigen::Index begin) {
    std::vector<double> off;
    for (Eigen::Index k = begin; k < begin + half; ++k)
      off.push_back(s[k] - static_cast<double>(k) * period);
    return upper_median(std::move(off));
  };
  return period + (usual(first + half) - usual(first)) / static_cast<double>(half);
}

}  // namespace

bool is_one_period(double dt, double rate_hz) {
  const double period = 1 / rate_hz;
  return std::abs(dt - period) <= kUnevenness * period;
}

bool is_ahead_alone(const Eigen::VectorXd& t, int k) {
  if (k < 1 || k + 2 >= t.size()) return false;
  return t[k + 1] > t[k - 1] && t[k + 2] > t[k + 1] && t[k] >= t[k + 2];
}

std::vector<int> lost_before(const Eigen::VectorXd& t, double rate_hz) {
  constexpr Eigen::Index kAbout = 15, kFew = 3;  // rows on either side that tell
  const double period = 1 / rate_hz;
  std::vector<int> lost(static_cast<std::size_t>(t.size()), 0);
  std::vector<Eigen::Index> late{0};  // rows that come after a gap or too late
  for (Eigen::Index k = 1; k < t.size(); ++k)
    if (t[k] - t[k - 1] > kGap * period) late.push_back(k);
  late.push_back(t.size());
  // usual difference of rows first .. last - 1 from an even clock
  const auto usual = [&](Eigen::Index first, Eigen::Index last) {
    std::vector<double> off;
    for (Eigen::Index k = first; k < last; ++k)
      off.push_back(t[k] - static_cast<double>(k) * period);
    return upper_median(off);
  };
  for (std::size_t i = 1; i + 1 < late.size(); ++i) {
    const Eigen::Index k = late[i];
    const Eigen::Index first = std::max(late[i - 1], k - kAbout),
                       last = std::min(late[i + 1], k + kAbout);
    double gap = usual(k, last) - usual(first, k);
    if (k - first < kFew || last - k < kFew) {
      gap = t[k] - t[k - 1] - period;
      if (k + 1 < t.size()) gap = std::min(gap, t[k + 1] - t[k - 1] - 2 * period);
      if (k > 1) gap = std::min(gap, t[k] - t[k - 2] - 2 * period);
    }
    constexpr double kMost = 2e9;
    lost[static_cast<std::size_t>(k)] =
        static_cast<int>(std::clamp(std::round(gap / period), 0.0, kMost));
  }
  return lost;
}

std::vector<int> rising_rows(const Eigen::VectorXd& t) {
  std::vector<int> rows;
  for (int k = 0; k < t.size(); ++k) {
    if (!rows.empty() && rows.back() == k - 1 && is_ahead_alone(t, k - 1)) rows.pop_back();
    if (rows.empty() || t[k] > t[rows.back()]) rows.push_back(k);
  }
  return rows;
}

std::vector<int> order_by_time(const Eigen::VectorXd& t) {
  std::vector<int> rows(static_cast<std::size_t>(t.size()));
  std::iota(rows.begin(), rows.end(), 0);
  std::ranges::stable_sort(rows, {}, [&](int k) { return t[k]; });
  return rows;
}

double rate_by_line(const Eigen::VectorXd& t, double rate_hz) {
  const Eigen::VectorXd s = without_gaps(t, rate_hz);
  const double length = length_of_line(s);
  return length > 0 ? static_cast<double>(s.size() - 1) / length : rate_hz;
}

std::optional<CoarseClock> coarse_clock(const Dataset& d) {
  constexpr double kFewest = 0.01;   // of the rows, that have the stamp of the row before
  constexpr int kLeast = 10;         // of them
  constexpr double kRepeats = 0.1;   // of the rows: fewer of an uneven clock are repeats
  constexpr double kCoarser = 1.01;  // than the samples
  constexpr double kWhole = 1e-3;    // of a step, that a period is off a whole number of them
  const Eigen::Index T = d.t.size();
  CoarseClock clock;
  Eigen::Index equal = 0, copies = 0;
  for (Eigen::Index k = 1; k < T; ++k) {
    const double dt = d.t[k] - d.t[k - 1];
    if (dt > 0) {
      if (clock.step_s == 0 || dt < clock.step_s) clock.step_s = dt;
      continue;
    }
    if (dt < 0) return {};
    ++equal;
    if (d.q.row(k) == d.q.row(k - 1) && d.tau.row(k) == d.tau.row(k - 1)) ++copies;
  }
  if (equal < kLeast || static_cast<double>(equal) < kFewest * static_cast<double>(T) ||
      2 * copies > equal)
    return {};
  for (Eigen::Index k = 1; k < T; ++k) {
    const double steps = (d.t[k] - d.t[k - 1]) / clock.step_s;
    if (!(std::abs(steps - std::round(steps)) < kWhole)) return {};
  }
  const double period = period_between_steps(d.t);
  if (!(period > 0)) return {};
  clock.rate_hz = 1 / period;
  if (clock.step_s * clock.rate_hz < kCoarser) return {};
  const double length = period * static_cast<double>(T - 1);
  const Eigen::ArrayXd off = d.t.array() - d.t.mean() - length * rows_about_middle(T).array();
  clock.fits_even = off.abs().maxCoeff() <= (1 + kWhole) * clock.step_s;
  if (!clock.fits_even && static_cast<double>(equal) < kRepeats * static_cast<double>(T)) return {};
  return clock;
}

ClockQuality quality_of_clock(const Eigen::VectorXd& t, double rate_hz) {
  constexpr Eigen::Index kLeast = 4;  // rows of a block
  const double period = 1 / rate_hz;
  const Eigen::VectorXd s = without_gaps(t, rate_hz);
  const Eigen::Index size = std::max(kLeast, s.size() / kBlocks);
  if (s.size() < 2 * size) return {};
  std::vector<double> means;
  double squares = 0, count = 0;
  for (Eigen::Index first = 0; first + size <= s.size(); first += size) {
    means.push_back(usual_period(s, first, size, period));
    for (Eigen::Index k = first + 1; k < first + size; ++k)
      if (const double dt = s[k] - s[k - 1]; dt < kGap * period) {
        squares += (dt - means.back()) * (dt - means.back());
        ++count;
      }
  }
  ClockQuality clock;
  if (count > 0) clock.jitter_s = std::sqrt(squares / count);
  const auto [low, high] = std::minmax_element(means.begin(), means.end());
  clock.drift = (*high - *low) / period;
  // Two stamps make a period: their errors cancel in a mean but for the ends.
  const double error = 2 * clock.jitter_s / static_cast<double>(size) / period;
  clock.drifts = clock.drift > kDrift && clock.drift > kCertain * error;
  return clock;
}

bool is_slight_jitter(const Eigen::VectorXd& t, double rate_hz) {
  const double period = 1 / rate_hz;
  bool even = true;
  for (Eigen::Index k = 1; k < t.size(); ++k) {
    const double dt = t[k] - t[k - 1];
    if (!(std::abs(dt - period) <= kSlightAtMost * period)) return false;
    even = even && is_one_period(dt, rate_hz);
  }
  const ClockQuality clock = quality_of_clock(t, rate_hz);
  return !even && clock.jitter_s <= kSlight * period && !clock.drifts;
}

}  // namespace fricid::data
