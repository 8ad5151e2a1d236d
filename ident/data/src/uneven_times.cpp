#include "fricid/data/uneven_times.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <span>
#include <vector>

#include "fricid/base/error.hpp"
#include "fricid/data/sample_times.hpp"

namespace fricid::data {
namespace {

constexpr double kLost = 2.5;  // periods between stamps that a cubic does not bridge
constexpr std::size_t kNodes = 4;

using Nodes = std::array<double, kNodes>;

/// Weights of the values at times `t` of the cubic through them, at time x (Lagrange).
Nodes cubic_weights(const Nodes& t, double x) {
  Nodes w;
  for (std::size_t i = 0; i < kNodes; ++i) {
    w[i] = 1;
    for (std::size_t j = 0; j < kNodes; ++j)
      if (j != i) w[i] *= (x - t[j]) / (t[i] - t[j]);
  }
  return w;
}

/// The larger of some errors, whatever a few of them are; 0 of none.
double upper_tenth(std::vector<double>& errors) {
  if (errors.empty()) return 0;
  const auto at = errors.begin() + static_cast<std::ptrdiff_t>(9 * errors.size() / 10);
  std::nth_element(errors.begin(), at, errors.end());
  return *at;
}

/// How far positions are off the cubic through their neighbours [rad].
struct Roughness {
  double by_stamps = 0, by_even_times = 0;
};

/// Of joint j over rows[begin] to rows[end - 1], but for those beside a pause.
Roughness roughness(const Dataset& d, std::span<const int> rows, int j, std::size_t begin,
                    std::size_t end) {
  static const Nodes even = cubic_weights({-2, -1, 1, 2}, 0);
  std::vector<double> by_stamps, by_even_times;
  for (std::size_t r = std::max<std::size_t>(2, begin); r < end && r + 2 < rows.size(); ++r) {
    const std::array<int, kNodes> beside{rows[r - 2], rows[r - 1], rows[r + 1], rows[r + 2]};
    Nodes t;
    for (std::size_t i = 0; i < kNodes; ++i) t[i] = d.t[beside[i]];
    const double own = d.t[rows[r]],
                 longest = std::max({t[1] - t[0], own - t[1], t[2] - own, t[3] - t[2]});
    if (longest > kGap / d.rate_hz) continue;  // a sample may be lost there
    const Nodes stamps = cubic_weights(t, own);
    double off = -d.q(rows[r], j), off_even = off;
    for (std::size_t i = 0; i < kNodes; ++i) {
      off += stamps[i] * d.q(beside[i], j);
      off_even += even[i] * d.q(beside[i], j);
    }
    if (!std::isfinite(off)) continue;
    by_stamps.push_back(std::abs(off));
    by_even_times.push_back(std::abs(off_even));
  }
  return {upper_tenth(by_stamps), upper_tenth(by_even_times)};
}

}  // namespace

Taken taken(const Dataset& d) {
  constexpr std::size_t kParts = 10;
  constexpr double kCertain = 3;  // standard errors
  const std::vector<int> rows = rising_rows(d.t);
  // by how much the stamps are the better times in each part of the log, in sum over the joints
  Eigen::Array<double, kParts, 1> gains = Eigen::Array<double, kParts, 1>::Zero();
  for (std::size_t part = 0; part < kParts; ++part)
    for (int j = 0; j < d.n(); ++j) {
      const Roughness found =
          roughness(d, rows, j, rows.size() * part / kParts, rows.size() * (part + 1) / kParts);
      if (const double sum = found.by_even_times + found.by_stamps; sum > 0)
        gains[static_cast<Eigen::Index>(part)] += (found.by_even_times - found.by_stamps) / sum;
    }
  const double mean = gains.mean(),
               error = std::sqrt((gains - mean).square().sum() / (kParts * (kParts - 1.0)));
  if (std::abs(mean) <= kCertain * error) return Taken::kNotTold;
  return mean > 0 ? Taken::kAtStamps : Taken::kEvenly;
}

Dataset at_even_times(Dataset d) {
  const std::vector<int> rows = rising_rows(d.t);
  const auto count = std::ssize(rows);
  if (count < static_cast<std::ptrdiff_t>(kNodes))
    throw UserError("{}: {} rows with times that rise; allowed: at least {}", d.name, count,
                    kNodes);
  const Dataset old = d;
  const auto stamp = [&](std::ptrdiff_t r) { return old.t[rows[static_cast<std::size_t>(r)]]; };
  const double begin = stamp(0);
  const auto length =
      static_cast<Eigen::Index>(std::floor((stamp(count - 1) - begin) * d.rate_hz * (1 + 1e-12))) +
      1;
  d.t = begin +
        Eigen::VectorXd::LinSpaced(length, 0, static_cast<double>(length - 1)).array() / d.rate_hz;
  for (RowMatrix* table : {&d.q, &d.v, &d.tau, &d.temperature})
    if (table->size() > 0) table->resize(length, table->cols());
  std::ptrdiff_t before = 0;  // the last row at or before the wanted time, but the last
  for (Eigen::Index k = 0; k < length; ++k) {
    while (before + 2 < count && stamp(before + 1) <= d.t[k]) ++before;
    const auto first =
        std::clamp<std::ptrdiff_t>(before - 1, 0, count - static_cast<std::ptrdiff_t>(kNodes));
    Nodes t;
    std::array<int, kNodes> at;
    for (std::size_t i = 0; i < kNodes; ++i) {
      at[i] = rows[static_cast<std::size_t>(first) + i];
      t[i] = old.t[at[i]];
    }
    const Nodes cubic = cubic_weights(t, d.t[k]);
    const double apart = stamp(before + 1) - stamp(before);
    const double share = (d.t[k] - stamp(before)) / apart;
    const bool lost = apart > kLost / d.rate_hz && share > 0 && share < 1;
    const auto fill = [&](const RowMatrix& from, RowMatrix& to, bool smooth) {
      if (to.size() == 0) return;
      if (lost)
        to.row(k).setConstant(std::numeric_limits<double>::quiet_NaN());
      else if (smooth)
        to.row(k) = cubic[0] * from.row(at[0]) + cubic[1] * from.row(at[1]) +
                    cubic[2] * from.row(at[2]) + cubic[3] * from.row(at[3]);
      else
        to.row(k) = (1 - share) * from.row(rows[static_cast<std::size_t>(before)]) +
                    share * from.row(rows[static_cast<std::size_t>(before + 1)]);
    };
    fill(old.q, d.q, true);
    fill(old.v, d.v, true);
    fill(old.tau, d.tau, false);
    fill(old.temperature, d.temperature, false);
  }
  return d;
}

}  // namespace fricid::data
