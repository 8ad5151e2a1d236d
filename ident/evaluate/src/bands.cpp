#include "fricid/evaluate/bands.hpp"

#include <algorithm>
#include <cmath>

#include "fricid/base/not_finite.hpp"
#include "fricid/base/parallel.hpp"
#include "fricid/base/progress.hpp"
#include "planned_rollouts.hpp"
#include "streams.hpp"

namespace fricid::evaluate {
namespace {

constexpr double kLow = 0.05, kHigh = 0.95;
constexpr double kNormal90 = 1.645;  // standard deviations

/// The p quantile of sorted values.
double quantile(const std::vector<double>& sorted, double p) {
  const double at = std::clamp(p * static_cast<double>(sorted.size() + 1) - 1, 0.0,
                               static_cast<double>(sorted.size() - 1));
  const auto below = static_cast<std::size_t>(at);
  const std::size_t above = std::min(below + 1, sorted.size() - 1);
  return sorted[below] + (at - static_cast<double>(below)) * (sorted[above] - sorted[below]);
}

/// One pack of draws of one member over one recording.
struct Task {
  std::size_t member, trajectory;
  int first;  ///< draw
};

/// Mean over the members of the rollout by the arm that was fitted, under the measured torque.
RowMatrix undisturbed(std::span<const Member> members, const Trajectory& trajectory,
                      const Start& start, const EvaluateOptions& options) {
  RowMatrix mean = RowMatrix::Zero(start.steps + 1, trajectory.data.n());
  for (const Member& member : members) {
    const Arm& arm = member.model->arm;
    const std::vector<double> z0 = first_state(arm, trajectory);
    const std::vector<OpenLoop> loop{{&arm, &trajectory, start, z0}};
    mean +=
        roll_out(loop, {{options.substeps, member.fitted.leap}, options.diverged_rad}).front().q;
  }
  return mean / static_cast<double>(members.size());
}

}  // namespace

Band reflected(const Band& band, const RowMatrix& centre) {
  return {(2 * centre - band.high).cwiseMin(centre), (2 * centre - band.low).cwiseMax(centre)};
}

Band band_of(std::span<const RowMatrix> draws) {
  const Eigen::Index rows = draws.front().rows(), n = draws.front().cols();
  Band band{RowMatrix(rows, n), RowMatrix(rows, n)};
  std::vector<double> values(draws.size());
  for (Eigen::Index k = 0; k < rows; ++k)
    for (Eigen::Index j = 0; j < n; ++j) {
      for (std::size_t i = 0; i < draws.size(); ++i) values[i] = draws[i](k, j);
      std::sort(values.begin(), values.end());
      band.low(k, j) = quantile(values, kLow);
      band.high(k, j) = quantile(values, kHigh);
    }
  return band;
}

BandScore score(const Band& band, const Trajectory& trajectory, int steps) {
  if (steps >= band.low.rows()) return {kNan, kNan};
  double inside = 0, squares = 0, count = 0;
  for (Eigen::Index k = 0; k <= steps; ++k)
    for (Eigen::Index j = 0; j < band.low.cols(); ++j) {
      const double wanted = trajectory.scored_q()(k, j);
      if (std::isnan(wanted)) continue;
      const double half = (band.high(k, j) - band.low(k, j)) / 2;
      const double wider = std::hypot(half, kNormal90 * trajectory.scored_q_sd(j)) - half;
      inside += band.low(k, j) - wider <= wanted && wanted <= band.high(k, j) + wider;
      squares += half * half;
      count += 1;
    }
  return {inside / count, std::sqrt(squares / count)};
}

std::vector<Band> open_loop_bands(std::span<const Member> members,
                                  std::span<const Trajectory> trajectories,
                                  const EvaluateOptions& options, int jobs) {
  std::vector<Task> tasks;
  const std::vector<Start> starts = plan_starts(trajectories, options.horizons_s, 0);
  for (std::size_t m = 0; m < members.size(); ++m)
    for (std::size_t i = 0; i < trajectories.size(); ++i) {
      for (int draw = 0; draw < options.draws; draw += PackD::kLanes) tasks.push_back({m, i, draw});
    }

  std::vector draws(
      trajectories.size(),
      std::vector<RowMatrix>(members.size() * static_cast<std::size_t>(options.draws)));
  parallel_for(static_cast<int>(tasks.size()), jobs, [&](int t) {
    throw_if_stopped();
    const auto [m, i, first] = tasks[static_cast<std::size_t>(t)];
    const Member& member = members[m];
    const TorqueError& error = member.fitted.error;
    const auto count = static_cast<std::size_t>(std::min(PackD::kLanes, options.draws - first));
    std::vector<RowMatrix> disturbance;
    for (std::size_t l = 0; l < count; ++l)
      disturbance.push_back(
          draw_torque_error(error, trajectories[i].data.dt(), starts[i].steps + 1,
                            static_cast<std::uint64_t>(member.model->seed),
                            stream_of(Purpose::kBand, i, first + static_cast<int>(l))));
    std::vector<std::vector<double>> z0;
    std::vector<OpenLoop> loops;
    for (std::size_t l = 0; l < count; ++l) {
      const Arm& arm = member.arm(static_cast<std::size_t>(first) + l);
      z0.push_back(first_state(arm, trajectories[i]));
      loops.push_back({&arm, &trajectories[i], starts[i], {}, &disturbance[l]});
    }
    for (std::size_t l = 0; l < count; ++l) loops[l].z0 = z0[l];
    std::vector<Rollout> rollouts = roll_out(
        loops, {{options.substeps, member.fitted.leap}, options.diverged_rad, error.slow_gain});
    for (std::size_t l = 0; l < count; ++l)
      draws[i][m * static_cast<std::size_t>(options.draws) + static_cast<std::size_t>(first) + l] =
          std::move(rollouts[l].q);
  });
  std::vector<Band> bands(trajectories.size());
  parallel_for(static_cast<int>(bands.size()), jobs, [&](int i) {
    const auto at = static_cast<std::size_t>(i);
    bands[at] =
        reflected(band_of(draws[at]), undisturbed(members, trajectories[at], starts[at], options));
  });
  return bands;
}

}  // namespace fricid::evaluate
