#include "fricid/data/sample_times.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

namespace fricid::data {
namespace {

constexpr double kDrift = 5e-4;        // of the period
constexpr std::size_t kBlocks = 10;    // of the log, for drift
constexpr double kCertain = 6;         // standard errors
constexpr double kSlight = 0.03;       // of the period, rms
constexpr double kSlightAtMost = 0.2;  // of the period

// Periods that are neither gaps nor repeats, in blocks of equal count.
std::vector<std::vector<double>> regular_periods(const Eigen::VectorXd& t, double period) {
  std::vector<double> all;
  for (Eigen::Index k = 1; k < t.size(); ++k) {
    const double dt = t[k] - t[k - 1];
    if (dt > 0 && dt < kGap * period) all.push_back(dt);
  }
  std::vector<std::vector<double>> blocks;
  const std::size_t size = std::max<std::size_t>(2, all.size() / kBlocks);
  for (std::size_t at = 0; at + size <= all.size(); at += size)
    blocks.emplace_back(all.begin() + static_cast<std::ptrdiff_t>(at),
                        all.begin() + static_cast<std::ptrdiff_t>(at + size));
  return blocks;
}

}  // namespace

bool is_one_period(double dt, double rate_hz) {
  const double period = 1 / rate_hz;
  return std::abs(dt - period) <= kUnevenness * period;
}

ClockQuality quality_of_clock(const Eigen::VectorXd& t, double rate_hz) {
  const double period = 1 / rate_hz;
  const auto blocks = regular_periods(t, period);
  if (blocks.size() < 2) return {};
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
  ClockQuality clock;
  clock.jitter_s = std::sqrt(squares / static_cast<double>(count));
  const auto [low, high] = std::minmax_element(means.begin(), means.end());
  clock.drift = (*high - *low) / period;
  const double error = 2 * clock.jitter_s / static_cast<double>(blocks[0].size()) / period;
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
