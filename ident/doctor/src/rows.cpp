// Rows that do not follow each other: of several sources in turn, or with others lost between them.
#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>
#include <vector>

#include "checks.hpp"
#include "fricid/base/upper_median.hpp"

namespace fricid::doctor {
namespace {

/// Rows from one of those to the next that medians are taken over: of a long log some, evenly.
Eigen::Index stride(Eigen::Index rows) {
  constexpr Eigen::Index kEnough = 50'000;
  return std::max<Eigen::Index>(1, rows / kEnough);
}

/// |q_j(k + lag) - q_j(k)|, those that are known.
std::vector<double> steps(const data::RowMatrix& q, Eigen::Index j, Eigen::Index lag) {
  const Eigen::Index every = stride(q.rows());
  std::vector<double> out;
  for (Eigen::Index k = 0; k + lag < q.rows(); k += every)
    if (const double step = std::abs(q(k + lag, j) - q(k, j)); std::isfinite(step))
      out.push_back(step);
  return out;
}

}  // namespace

std::optional<Finding> find_sources_in_turn(const data::Dataset& d) {
  constexpr int kMostSources = 4;
  constexpr double kFarther = 10;    // from row to row than from one of a source to its next
  constexpr double kOfRange = 0.01;  // of the range of a position, at least
  for (int sources = 2; sources <= kMostSources; ++sources) {
    int leaping = 0, moving = 0;
    for (Eigen::Index j = 0; j < d.n(); ++j) {
      const double range = d.q.col(j).maxCoeff<Eigen::PropagateNumbers>() -
                           d.q.col(j).minCoeff<Eigen::PropagateNumbers>();
      if (!(range > 0)) continue;
      ++moving;
      const double next = upper_median(steps(d.q, j, 1)),
                   own = upper_median(steps(d.q, j, sources));
      leaping += next > kFarther * own && next > kOfRange * range;
    }
    if (moving == 0 || 2 * leaping <= moving) continue;
    return Finding{.kind = FindingKind::kInTurn,
                   .signal = "q",
                   .begin_s = d.t[0],
                   .end_s = d.t[d.length() - 1],
                   .size = static_cast<double>(sources),
                   .unit = "sources, a row each"};
  }
  return {};
}

std::optional<Finding> find_lost_rows(const data::Dataset& d) {
  constexpr double kMoves = 8;           // noise of a step
  constexpr double kSteady = 0.1;        // steps before and after differ by less of their mean
  constexpr double kWhole = 0.15;        // off a whole number of steps
  constexpr double kAlike = 0.15;        // joints differ by less of the step
  constexpr int kMost = 5, kFewest = 5;  // rows lost together; places
  constexpr double kShare = 5e-4;        // of the rows in motion
  constexpr double kMany = 0.01;         // of them: a fit would be wrong
  constexpr int kRather = 4;             // times as many as steps of one and a half
  const Eigen::Index n = d.n(), T = d.length();
  const Eigen::Index every = stride(T);
  Eigen::RowVectorXd noise(n);
  for (Eigen::Index j = 0; j < n; ++j) {
    std::vector<double> bends;
    for (Eigen::Index k = 1; k + 1 < T; k += every)
      if (const double bend = std::abs(d.q(k + 1, j) - 2 * d.q(k, j) + d.q(k - 1, j));
          std::isfinite(bend))
        bends.push_back(bend);
    noise[j] = upper_median(std::move(bends));
  }
  Finding lost{.kind = FindingKind::kLost, .signal = "q tau", .unit = "rows", .count = 0};
  int moving = 0, between = 0;
  for (Eigen::Index k = 1; k + 2 < T; ++k) {
    double before = 0, apart = 0, along = 0, size = 0;
    int joints = 0;
    const Eigen::RowVectorXd first = d.q.row(k) - d.q.row(k - 1),
                             step = d.q.row(k + 1) - d.q.row(k),
                             last = d.q.row(k + 2) - d.q.row(k + 1);
    for (Eigen::Index j = 0; j < n; ++j) {
      const double mean = (first[j] + last[j]) / 2;
      if (!(std::abs(mean) > kMoves * noise[j])) continue;
      ++joints;
      before += mean * mean;
      apart += std::pow(first[j] - last[j], 2);
      along += step[j] * mean;
      size += step[j] * step[j];
    }
    if (joints < std::min<Eigen::Index>(2, n) || !(apart < kSteady * kSteady * before)) continue;
    ++moving;
    const double factor = along / before;
    if (!(size - factor * along < kAlike * kAlike * size)) continue;
    const double whole = std::round(factor);
    if (std::abs(factor - 1.5) < kWhole) ++between;
    if (whole < 2 || whole > kMost + 1 || std::abs(factor - whole) > kWhole) continue;
    if (lost.count++ == 0) lost.begin_s = d.t[k];
    lost.end_s = d.t[k + 1];
    lost.size += whole - 1;
    lost.rows.insert(lost.rows.end(), static_cast<std::size_t>(whole) - 1, static_cast<int>(k) + 1);
  }
  if (lost.count < std::max<double>(kFewest, kShare * moving) || lost.count < kRather * between)
    return {};
  lost.is_severe = lost.count > kMany * moving;
  return lost;
}

}  // namespace fricid::doctor
