// Rows that keep the values of an earlier one, of a source that is slower than the log.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "checks.hpp"
#include "fricid/base/upper_median.hpp"

namespace fricid::doctor {
namespace {

constexpr double kSlowController = 240;  // [Hz] below it a torque that is held is one that is old

/// Rows at which a table changes, at every `samples`-th alone.
struct Hold {
  int samples = 1;  ///< 1: at any
  std::vector<int> fresh;
};

Hold hold_of(const data::RowMatrix& x) {
  constexpr std::size_t kLeast = 50;  // fresh rows
  constexpr double kRegular = 0.95;   // share of their distances that are multiples of the usual
  Hold hold;
  for (Eigen::Index k = 1; k < x.rows(); ++k)
    if (x.row(k) != x.row(k - 1)) hold.fresh.push_back(static_cast<int>(k));
  std::vector<double> distances;
  for (std::size_t i = 1; i < hold.fresh.size(); ++i)
    distances.push_back(hold.fresh[i] - hold.fresh[i - 1]);
  if (distances.size() < kLeast) return hold;
  const auto usual = static_cast<int>(upper_median(distances));
  const auto regular = std::ranges::count_if(
      distances, [usual](double d) { return static_cast<int>(d) % usual == 0; });
  if (static_cast<double>(regular) >= kRegular * static_cast<double>(distances.size()))
    hold.samples = usual;
  return hold;
}

/// The fresh rows, and while all values rest one for each period of the source.
std::vector<int> rows_of_source(const Hold& hold, int length) {
  std::vector<int> rows;
  for (int k = hold.fresh.front() % hold.samples; k < length; k += hold.samples) {
    const auto next = std::ranges::lower_bound(hold.fresh, k - hold.samples / 2);
    if (next != hold.fresh.end() && *next <= k + hold.samples / 2) k = *next;
    rows.push_back(k);
  }
  return rows;
}

}  // namespace

std::optional<Finding> find_held(const data::Dataset& d) {
  const Hold of_q = hold_of(d.q), of_tau = hold_of(d.tau);
  const bool both = of_q.samples == of_tau.samples, moves_held = of_q.samples > 1;
  const Hold& hold = moves_held ? of_q : of_tau;
  if (hold.samples == 1) return {};
  const double rate_hz = d.rate_hz / hold.samples;
  return Finding{.kind = FindingKind::kHeld,
                 .signal = both         ? "q tau"
                           : moves_held ? "q"
                                        : "tau",
                 .begin_s = d.t[0],
                 .end_s = d.t[d.length() - 1],
                 .size = static_cast<double>(hold.samples),
                 .unit = fmt::format("rows of one value, as of a source of {:.4g} Hz{}", rate_hz,
                                     moves_held ? "" : ", unless its controller holds it so"),
                 .rows = rows_of_source(hold, d.length()),
                 .is_severe = moves_held || rate_hz < kSlowController};
}

}  // namespace fricid::doctor
