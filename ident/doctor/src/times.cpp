#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "checks.hpp"
#include "fricid/data/sample_times.hpp"
#include "fricid/data/uneven_times.hpp"

namespace fricid::doctor {
namespace {

constexpr double kBack = 0.1;           // [s] that a clock which starts again goes back
constexpr std::size_t kMostListed = 8;  // one by one; more are one finding

/// Uneven stamps at which the samples were taken.
std::optional<Finding> find_uneven(const data::Dataset& d, const data::ClockQuality& clock) {
  if (clock.jitter_s <= data::kUnevenness / d.rate_hz || data::taken(d) != data::Taken::kAtStamps)
    return {};
  return Finding{.kind = FindingKind::kUneven,
                 .signal = "t",
                 .begin_s = d.t[0],
                 .end_s = d.t[d.length() - 1],
                 .size = 1e3 * clock.jitter_s,
                 .unit = "ms rms"};
}

// Jitter where periods scatter, or where one of them is what the reader refuses: not even, though
// no sample is lost in it and the clock does not drift.
void check_regularity(const data::Dataset& d, const data::ClockQuality& clock,
                      const Eigen::VectorXd& rising, const std::vector<int>& lost,
                      Findings& findings) {
  const double period = 1 / d.rate_hz, begin = d.t[0], end = d.t[d.length() - 1];
  double farthest = 0;
  for (Eigen::Index k = 1; k < rising.size(); ++k)
    if (const double dt = rising[k] - rising[k - 1];
        lost[static_cast<std::size_t>(k)] == 0 && !data::is_one_period(dt, d.rate_hz))
      farthest = std::max(farthest, std::abs(dt - period));
  const bool scatters = clock.jitter_s > data::kUnevenness * period;
  if (scatters || (farthest > 0 && !clock.drifts))
    findings.push_back({.kind = FindingKind::kJitter,
                        .signal = "t",
                        .begin_s = begin,
                        .end_s = end,
                        .size = 1e3 * (scatters ? clock.jitter_s : farthest),
                        .unit = scatters ? "ms rms" : "ms at most"});
  if (clock.drifts)
    findings.push_back({.kind = FindingKind::kClockDrift,
                        .signal = "t",
                        .begin_s = begin,
                        .end_s = end,
                        .size = 100 * clock.drift,
                        .unit = "% of the period"});
}

constexpr double kLost = 2;  // periods by which what a clock goes back by may be off

// What a counter of 16, 31 or 32 bits that counts ms, us or ns goes back by when it is full; 0:
// none of them goes back so far. [s]
double range_of_counter(double back, double period) {
  for (const double ticks : {0x1p16, 0x1p31, 0x1p32})
    for (const double second : {1e3, 1e6, 1e9})
      if (std::abs(back + period - ticks / second) <= kLost * period) return ticks / second;
  return 0;
}

// Whether the arm moves on from row k - 1 to row k as before and after, so that nothing ends there.
bool moves_on(const data::RowMatrix& q, int k) {
  constexpr double kAlike = 0.15;  // of the step
  if (k < 2 || k + 1 >= q.rows()) return false;
  const Eigen::RowVectorXd mean = (q.row(k - 1) - q.row(k - 2) + q.row(k + 1) - q.row(k)) / 2;
  return (q.row(k) - q.row(k - 1) - mean).norm() < kAlike * mean.norm();
}

// Appends those of one kind.
void append(Findings some, Findings& findings) {
  if (some.size() > kMostListed) {
    Finding all = some.front();
    all.end_s = some.back().end_s;
    all.count = static_cast<int>(some.size());
    for (std::size_t i = 1; i < some.size(); ++i) all.size += some[i].size;
    some = {all};
  }
  findings.insert(findings.end(), some.begin(), some.end());
}

}  // namespace

// A row that is behind has its place where its stamp is: a stamp that is wrong comes too near to
// those of others, and stamps that went to the wrong rows make the motion rougher.
std::optional<Finding> find_out_of_order(const data::Dataset& d) {
  constexpr double kFarthest = 1;  // [s]
  constexpr double kRoom = 0.6;    // periods to the stamps before and after
  constexpr double kShare = 0.9;   // of the rows that are behind, with such room
  constexpr double kSmoother = 0.8;
  std::vector<char> is_behind(static_cast<std::size_t>(d.length()), 0);
  Finding found{.kind = FindingKind::kOutOfOrder, .signal = "t", .unit = "rows", .count = 0};
  double latest = d.t[0];
  for (int k = 1; k < d.length(); ++k) {
    if (latest - d.t[k] > kFarthest) return {};
    if (d.t[k] < latest) {
      if (found.count++ == 0) found.begin_s = d.t[k];
      found.end_s = d.t[k];
      is_behind[static_cast<std::size_t>(k)] = 1;
    }
    latest = std::max(latest, d.t[k]);
  }
  if (found.count == 0) return {};
  const std::vector<int> order = data::order_by_time(d.t);
  int with_room = 0;
  for (std::size_t i = 0; i < order.size(); ++i) {
    if (is_behind[static_cast<std::size_t>(order[i])] == 0) continue;
    const double own = d.t[order[i]], room = kRoom / d.rate_hz;
    with_room += (i == 0 || own - d.t[order[i - 1]] > room) &&
                 (i + 1 == order.size() || d.t[order[i + 1]] - own > room);
  }
  if (with_room < kShare * found.count) return {};
  const auto by_stamp = [&](int k) { return order[static_cast<std::size_t>(k)]; };
  const auto by_place = [](int k) { return k; };
  const auto is_moved = [&](int k) { return by_stamp(k) != k; };
  const auto roughness = [&](const auto& row_at) {  // where the two differ
    double sum = 0;
    for (int k = 1; k + 1 < d.length(); ++k) {
      if (!is_moved(k - 1) && !is_moved(k) && !is_moved(k + 1)) continue;
      const double bend =
          (d.q.row(row_at(k + 1)) - 2 * d.q.row(row_at(k)) + d.q.row(row_at(k - 1))).norm();
      if (std::isfinite(bend)) sum += bend;
    }
    return sum;
  };
  if (!(roughness(by_stamp) < kSmoother * roughness(by_place))) return {};
  found.size = found.count;
  return found;
}

// A stamp that is back alone is a duplicate: the next one is later than all before. A clock that
// goes back by the same time again and again, by the range of a counter or in the middle of a
// motion, began again as that of a minute does; else another recording begins.
void check_restarts(const data::Dataset& d, Findings& findings) {
  const double period = 1 / d.rate_hz;
  Findings restarts;
  Finding wrap{.kind = FindingKind::kWrap, .signal = "t", .count = 0};
  bool goes_on = false;
  double latest = d.t[0];
  for (int k = 1; k < d.length(); ++k) {
    if (data::is_ahead_alone(d.t, k)) continue;
    const double back = d.t[k - 1] - d.t[k];
    if (back > kBack && !data::is_ahead_alone(d.t, k - 1) && k + 1 < d.length() &&
        d.t[k + 1] <= latest) {
      restarts.push_back({.kind = FindingKind::kRestart,
                          .signal = "t",
                          .begin_s = d.t[k - 1],
                          .end_s = d.t[k],
                          .size = back,
                          .unit = fmt::format("s back after row {}", k)});
      const double of_counter = range_of_counter(back, period);
      const double range = of_counter > 0 ? of_counter : back + period;
      if (wrap.rows.empty()) wrap.size = range;
      goes_on = goes_on || of_counter > 0 || moves_on(d.q, k);
      if (std::abs(wrap.size - range) <= kLost * period) wrap.rows.push_back(k);
      latest = d.t[k];
    }
    latest = std::max(latest, d.t[k]);
  }
  if (goes_on && wrap.rows.size() == restarts.size()) {
    wrap.count = static_cast<int>(restarts.size());
    wrap.begin_s = restarts.front().begin_s;
    wrap.end_s = restarts.back().end_s + wrap.count * wrap.size;
    wrap.unit = fmt::format("s back after row {}, the range of its clock", wrap.rows[0]);
    restarts = {wrap};
  }
  append(std::move(restarts), findings);
}

void check_clock(const data::Dataset& d, Findings& findings) {
  findings.push_back({.kind = FindingKind::kRate,
                      .signal = "t",
                      .begin_s = d.t[0],
                      .end_s = d.t[d.length() - 1],
                      .size = d.rate_hz,
                      .unit = "Hz"});

  Finding repeats{.kind = FindingKind::kDuplicate, .signal = "t", .unit = "rows", .count = 0};
  const std::vector<int> rows = data::rising_rows(d.t);
  for (int k = 0, next = 0; k < d.length(); ++k) {
    if (next < static_cast<int>(rows.size()) && rows[static_cast<std::size_t>(next)] == k) {
      ++next;
      continue;
    }
    if (repeats.count++ == 0) repeats.begin_s = d.t[k];
    repeats.end_s = d.t[k];
    repeats.size = repeats.count;
    repeats.rows.push_back(k);
  }
  Findings gaps;
  const Eigen::VectorXd rising = d.t(rows);
  const std::vector<int> lost = data::lost_before(rising, d.rate_hz);
  for (Eigen::Index k = 1; k < rising.size(); ++k)
    if (const int count = lost[static_cast<std::size_t>(k)]; count > 0)
      gaps.push_back({.kind = FindingKind::kGap,
                      .signal = "t",
                      .begin_s = rising[k - 1],
                      .end_s = rising[k],
                      .size = static_cast<double>(count),
                      .unit = "samples"});
  const data::ClockQuality clock = data::quality_of_clock(d.t, d.rate_hz);
  std::optional<Finding> uneven = find_uneven(d, clock);
  if (!uneven) append(std::move(gaps), findings);
  if (repeats.count > 0) findings.push_back(repeats);
  if (uneven)
    findings.push_back(std::move(*uneven));
  else
    check_regularity(d, clock, rising, lost, findings);
}

}  // namespace fricid::doctor
