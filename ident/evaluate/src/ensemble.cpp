#include "fricid/evaluate/ensemble.hpp"

#include <cmath>

#include "fricid/base/not_finite.hpp"
#include "fricid/evaluate/statistics.hpp"

namespace fricid::evaluate {

EnsembleScore ensemble_score(std::span<const Rollout* const> members, const Trajectory& trajectory,
                             int steps) {
  const Rollout& first = *members.front();
  if (steps >= first.q.rows()) return {kNan, kNan};
  const auto k = static_cast<double>(members.size());
  const double width =
      student_t_quantile(0.95, static_cast<int>(members.size()) - 1) * std::sqrt(1 + 1 / k);
  double squares = 0, inside = 0, count = 0;
  for (Eigen::Index row = 0; row <= steps; ++row)
    for (Eigen::Index j = 0; j < first.q.cols(); ++j) {
      const double wanted = trajectory.scored_q()(first.start.begin + row, j);
      if (std::isnan(wanted)) continue;
      double mean = 0, variance = 0;
      for (const Rollout* member : members) mean += member->q(row, j) / k;
      for (const Rollout* member : members) {
        const double off = member->q(row, j) - mean;
        variance += off * off / (k - 1);
      }
      squares += (mean - wanted) * (mean - wanted);
      inside += std::abs(mean - wanted) <= width * std::sqrt(variance);
      count += 1;
    }
  return {squares / count, inside / count};
}

}  // namespace fricid::evaluate
