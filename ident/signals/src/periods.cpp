#include "fricid/signals/periods.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "fricid/base/eigen_instances.hpp"
#include "fricid/base/parallel.hpp"
#include "fricid/base/upper_median.hpp"

namespace fricid::signals {
namespace {

constexpr double kStep = 0.02;  // [s] of the search
constexpr double kSame = 0.05, kNear = 0.1, kAway = 0.5;
constexpr double kStill = 1e-3;     // [rad or m] sd of a joint that does not move
constexpr double kMoving = 0.2;     // of the rms speed
constexpr int kMoments = 2000;      // that are compared, at most
constexpr int kFewestMoments = 50;  // .. at least
constexpr double kLength = 0.02;    // by which recordings of one motion may differ

/// Positions over their standard deviations, of the joints that move, every `stride` samples.
struct Scaled {
  RowMatrix x;
  std::vector<Eigen::Index> moving;  ///< samples
};

Scaled scaled(ConstRowMatrix q, Eigen::Index stride) {
  const Eigen::Index count = (q.rows() + stride - 1) / stride;
  Scaled out{RowMatrix(count, q.cols()), {}};
  Eigen::Index joints = 0;
  for (Eigen::Index j = 0; j < q.cols(); ++j) {
    Eigen::VectorXd x(count);
    for (Eigen::Index k = 0; k < count; ++k) x[k] = q(k * stride, j);
    const auto known = x.array().isFinite();
    const double of = static_cast<double>(known.count()),
                 mean = known.select(x.array(), 0).sum() / of,
                 sd = std::sqrt(known.select(x.array() - mean, 0).square().sum() / of);
    if (sd > kStill) out.x.col(joints++) = x / sd;
  }
  out.x.conservativeResize(count, joints);
  if (joints == 0 || count < 3) return out;
  const Eigen::VectorXd speed =
      (out.x.bottomRows(count - 2) - out.x.topRows(count - 2)).rowwise().norm();
  const double square = speed.array().isFinite().select(speed.array(), 0).square().sum();
  const double least = kMoving * std::sqrt(square / static_cast<double>(count - 2));
  for (Eigen::Index k = 0; k < count - 2; ++k)
    if (speed[k] > least) out.moving.push_back(k + 1);
  return out;
}

/// The median distance of b, `lag` samples on, from a; infinite where too little can be compared.
double distance(const Scaled& a, const RowMatrix& b, Eigen::Index lag) {
  const auto end = std::ranges::lower_bound(a.moving, b.rows() - lag) - a.moving.begin();
  if (end < kFewestMoments) return std::numeric_limits<double>::infinity();
  std::vector<double> squares;
  const auto every = std::max<std::ptrdiff_t>(1, end / kMoments);
  for (std::ptrdiff_t i = 0; i < end; i += every) {
    const Eigen::Index k = a.moving[static_cast<std::size_t>(i)];
    const double square = (b.row(k + lag) - a.x.row(k)).squaredNorm();
    if (std::isfinite(square)) squares.push_back(square);
  }
  if (squares.empty()) return std::numeric_limits<double>::infinity();
  return std::sqrt(upper_median(std::move(squares)) / static_cast<double>(a.x.cols()));
}

}  // namespace

int period_of(ConstRowMatrix q, double dt, const PeriodRange& range) {
  const auto stride = std::max<Eigen::Index>(1, std::lround(kStep / dt));
  const Scaled coarse = scaled(q, stride);
  if (coarse.x.cols() == 0) return 0;
  const double step = static_cast<double>(stride) * dt;
  const auto last = static_cast<Eigen::Index>(
      std::min(range.longest_s / step, static_cast<double>(coarse.x.rows()) / range.least_count));
  double away = 0, before = std::numeric_limits<double>::infinity();
  for (Eigen::Index lag = 1; lag <= last + 1; ++lag) {
    const double at =
        lag <= last ? distance(coarse, coarse.x, lag) : std::numeric_limits<double>::infinity();
    if (std::isfinite(at)) away = std::max(away, at);
    const bool passed = static_cast<double>(lag - 1) * step > range.shortest_s && before < kNear &&
                        at > before && away > kAway;
    before = at;
    if (!passed) continue;
    const Scaled fine = scaled(q, 1);
    const Eigen::Index centre = (lag - 1) * stride;
    Eigen::Index best = centre;
    double least = std::numeric_limits<double>::infinity();
    const auto most = static_cast<Eigen::Index>(static_cast<double>(q.rows()) / range.least_count);
    for (Eigen::Index k = centre - stride; k <= std::min(most, centre + stride); ++k)
      if (const double d = distance(fine, fine.x, k); d < least) least = d, best = k;
    if (least < kSame) return static_cast<int>(best);
  }
  return 0;
}

bool is_same_motion(ConstRowMatrix a, ConstRowMatrix b) {
  const auto longer = static_cast<double>(std::max(a.rows(), b.rows())),
             shorter = static_cast<double>(std::min(a.rows(), b.rows()));
  if (a.cols() != b.cols() || longer - shorter > kLength * longer) return false;
  const Eigen::Index rows = std::min(a.rows(), b.rows());
  // side by side, so that both have one scale
  RowMatrix both(2 * rows, a.cols());
  both << a.topRows(rows), b.topRows(rows);
  Scaled of_both = scaled(both, 1);
  std::erase_if(of_both.moving, [&](Eigen::Index k) { return k >= rows; });
  return of_both.x.cols() > 0 && distance(of_both, of_both.x, rows) < kSame;
}

void number_motions(std::span<Recording> recordings) {
  std::vector<const Recording*> firsts;
  for (Recording& r : recordings) {
    const auto found = std::ranges::find_if(firsts, [&](const Recording* first) {
      return is_same_motion(first->narrow.q, r.narrow.q);
    });
    r.motion_number = static_cast<int>(found - firsts.begin());
    if (found == firsts.end()) firsts.push_back(&r);
  }
}

void mark_repeats(std::span<Recording> recordings, int jobs) {
  parallel_for(static_cast<int>(recordings.size()), jobs, [&](int i) {
    Recording& r = recordings[static_cast<std::size_t>(i)];
    r.period = period_of(r.narrow.q, r.dt);
  });
  number_motions(recordings);
}

}  // namespace fricid::signals
