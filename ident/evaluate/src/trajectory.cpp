#include "fricid/evaluate/trajectory.hpp"

#include <algorithm>
#include <cmath>

namespace fricid::evaluate {

Trajectory part_of(const Trajectory& whole, int begin, int end) {
  const auto rows = [&](const RowMatrix& x) -> RowMatrix {
    return x.rows() == 0 ? x : RowMatrix(x.middleRows(begin, end - begin));
  };
  Trajectory part;
  part.data = whole.data;
  part.data.t = whole.data.t.segment(begin, end - begin);
  for (RowMatrix data::Dataset::*signal :
       {&data::Dataset::q, &data::Dataset::tau, &data::Dataset::v, &data::Dataset::temperature})
    part.data.*signal = rows(whole.data.*signal);
  part.q = rows(whole.q);
  part.v = rows(whole.v);
  part.a = rows(whole.a);
  return part;
}

RowMatrix held_torque(const data::Dataset& dataset) {
  RowMatrix tau = dataset.tau;
  for (Eigen::Index j = 0; j < tau.cols(); ++j) {
    double last = 0;
    for (Eigen::Index k = 0; k < tau.rows(); ++k) {
      if (std::isfinite(tau(k, j))) last = tau(k, j);
      tau(k, j) = last;
    }
  }
  return tau;
}

int horizon_steps(double horizon_s, double dt, int T) {
  constexpr double kRounded = 1.01;
  const int last = T - 1, steps = static_cast<int>(std::lround(horizon_s / dt));
  return horizon_s == 0 || (steps > last && steps <= kRounded * last) ? last : steps;
}

std::vector<Start> plan_starts(std::span<const Trajectory> trajectories,
                               std::span<const double> horizons_s, int starts) {
  std::vector<Start> plan;
  for (int i = 0; i < std::ssize(trajectories); ++i) {
    const data::Dataset& data = trajectories[static_cast<std::size_t>(i)].data;
    const int last = data.length() - 1;
    int from_first = 0, from_later = 0;
    for (const double h : horizons_s) {
      const int steps = std::min(horizon_steps(h, data.dt(), data.length()), last);
      from_first = std::max(from_first, steps);
      if (steps < last) from_later = std::max(from_later, steps);
    }
    if (from_first > 0) plan.push_back({i, 0, from_first});
    if (from_later == 0) continue;
    for (int s = 1; s <= starts; ++s) {
      const double share = static_cast<double>(s) / starts;
      plan.push_back({i, static_cast<int>(std::lround(share * (last - from_later))), from_later});
    }
  }
  return plan;
}

}  // namespace fricid::evaluate
