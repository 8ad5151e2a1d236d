#include <algorithm>
#include <cmath>

#include "checks.hpp"

namespace fricid::doctor {
namespace {

constexpr double kGap = 1.5;          // periods
constexpr double kJitter = 0.01;      // of the period
constexpr double kDrift = 5e-4;       // of the period
constexpr int kBlocks = 10;           // of the log, for drift
constexpr double kCertain = 6;        // standard errors
constexpr std::size_t kMostGaps = 8;  // listed one by one; more are one finding

// Periods that are neither gaps nor repeats, in blocks of equal count.
std::vector<std::vector<double>> regular_periods(const data::Dataset& d, double period) {
  std::vector<double> all;
  for (int k = 1; k < d.length(); ++k) {
    const double dt = d.t[k] - d.t[k - 1];
    if (dt > 0 && dt < kGap * period) all.push_back(dt);
  }
  std::vector<std::vector<double>> blocks;
  const std::size_t size = std::max<std::size_t>(2, all.size() / kBlocks);
  for (std::size_t at = 0; at + size <= all.size(); at += size)
    blocks.emplace_back(all.begin() + static_cast<std::ptrdiff_t>(at),
                        all.begin() + static_cast<std::ptrdiff_t>(at + size));
  return blocks;
}

void check_regularity(const data::Dataset& d, double period, Findings& findings) {
  const auto blocks = regular_periods(d, period);
  if (blocks.size() < 2) return;
  // Two stamps make a period: their errors cancel in a mean but for the ends.
  std::vector<double> means;
  double squares = 0;
  std::size_t count = 0;
  for (const std::vector<double>& block : blocks) {
    double sum = 0;
    for (const double dt : block) sum += dt;
    means.push_back(sum / static_cast<double>(block.size()));
    for (const double dt : block) squares += (dt - means.back()) * (dt - means.back());
    count += block.size();
  }
  const double spread = std::sqrt(squares / static_cast<double>(count));
  const double begin = d.t[0], end = d.t[d.length() - 1];
  if (spread > kJitter * period)
    findings.push_back({.kind = FindingKind::kJitter,
                        .signal = "t",
                        .begin_s = begin,
                        .end_s = end,
                        .size = 1e3 * spread,
                        .unit = "ms rms"});
  const auto [low, high] = std::minmax_element(means.begin(), means.end());
  const double drift = (*high - *low) / period;
  const double error = 2 * spread / static_cast<double>(blocks[0].size()) / period;
  if (drift > kDrift && drift > kCertain * error)
    findings.push_back({.kind = FindingKind::kClockDrift,
                        .signal = "t",
                        .begin_s = begin,
                        .end_s = end,
                        .size = 100 * drift,
                        .unit = "% of the period"});
}

}  // namespace

double median(std::vector<double> x) {
  if (x.empty()) return 0;
  const auto middle = x.begin() + static_cast<std::ptrdiff_t>(x.size() / 2);
  std::nth_element(x.begin(), middle, x.end());
  return *middle;
}

void check_clock(const data::Dataset& d, Findings& findings) {
  std::vector<double> periods;
  for (int k = 1; k < d.length(); ++k) periods.push_back(d.t[k] - d.t[k - 1]);
  const double period = median(periods);
  findings.push_back({.kind = FindingKind::kRate,
                      .signal = "t",
                      .begin_s = d.t[0],
                      .end_s = d.t[d.length() - 1],
                      .size = d.rate_hz,
                      .unit = "Hz"});

  Finding repeats{.kind = FindingKind::kDuplicate, .signal = "t", .unit = "rows", .count = 0};
  Findings gaps;
  for (int k = 1; k < d.length(); ++k) {
    const double dt = d.t[k] - d.t[k - 1];
    if (dt <= 0) {
      if (repeats.count++ == 0) repeats.begin_s = d.t[k];
      repeats.end_s = d.t[k];
      repeats.size = repeats.count;
      repeats.rows.push_back(k);
    } else if (dt > kGap * period) {
      gaps.push_back({.kind = FindingKind::kGap,
                      .signal = "t",
                      .begin_s = d.t[k - 1],
                      .end_s = d.t[k],
                      .size = std::round(dt / period) - 1,
                      .unit = "samples"});
    }
  }
  if (gaps.size() > kMostGaps) {
    Finding all = gaps.front();
    all.end_s = gaps.back().end_s;
    all.count = static_cast<int>(gaps.size());
    for (std::size_t i = 1; i < gaps.size(); ++i) all.size += gaps[i].size;
    gaps = {all};
  }
  findings.insert(findings.end(), gaps.begin(), gaps.end());
  if (repeats.count > 0) findings.push_back(repeats);
  check_regularity(d, period, findings);
}

}  // namespace fricid::doctor
