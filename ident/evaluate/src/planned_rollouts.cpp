#include "planned_rollouts.hpp"

#include <algorithm>
#include <functional>
#include <numeric>
#include <utility>

#include "fricid/base/error.hpp"
#include "fricid/base/parallel.hpp"
#include "fricid/base/progress.hpp"
#include "fricid/evaluate/constant_friction.hpp"
#include "fricid/system/initial_state.hpp"
#include "fricid/system/transmission.hpp"

namespace fricid::evaluate {
namespace {

/// A recording at the motors (T, n).
struct AtMotors {
  RowMatrix q, v, tau;
};
AtMotors at_motors(const Arm& arm, const Trajectory& trajectory) {
  const Transmission motors(arm.robot);
  return {motors.to_motors(trajectory.q), motors.to_motors(trajectory.v),
          motors.torque_to_motors(held_torque(trajectory.data))};
}

}  // namespace

std::vector<std::vector<int>> batches_of(std::span<const Start> starts) {
  std::vector<int> order(starts.size());
  std::iota(order.begin(), order.end(), 0);
  std::ranges::stable_sort(order, std::ranges::greater(),
                           [&](int i) { return starts[static_cast<std::size_t>(i)].steps; });
  std::vector<std::vector<int>> batches;
  for (std::size_t i = 0; i < order.size(); ++i) {
    if (i % PackD::kLanes == 0) batches.emplace_back();
    batches.back().push_back(order[i]);
  }
  return batches;
}

Plan make_plan(std::span<const Trajectory> trajectories, const EvaluateOptions& options) {
  Plan plan;
  plan.starts = plan_starts(trajectories, options.horizons_s, options.starts);
  plan.batches = batches_of(plan.starts);
  plan.by_trajectory.resize(trajectories.size());
  for (const Start& start : plan.starts) {
    auto& own = plan.by_trajectory[static_cast<std::size_t>(start.trajectory)];
    plan.rank.push_back(static_cast<int>(own.size()));
    own.push_back(start);
  }
  return plan;
}

std::vector<double> first_state(const Arm& arm, const Trajectory& trajectory) {
  const AtMotors at = at_motors(arm, trajectory);
  return initial_friction_state(arm, trajectory.data.dt(), at.q, at.v, at.tau,
                                trajectory.data.temperature);
}

Driven drive(const data::ModelFile& model, const dynamics::RobotModel& known,
             const Trajectory& trajectory, std::span<const Start> starts) {
  const data::Dataset& data = trajectory.data;
  const AtMotors at = at_motors(model.arm, trajectory);
  const std::vector<double> start =
      initial_friction_state(model.arm, data.dt(), at.q, at.v, at.tau, data.temperature);
  const DrivenFriction driven =
      drive_friction(model.arm.friction, data.dt(), at.q, at.v, at.tau, data.temperature, start);
  const bool from_truth = model.is_oracle && trajectory.truth && trajectory.truth->z.size() > 0;
  const RowMatrix& z = from_truth ? trajectory.truth->z : driven.z;
  if (z.cols() != driven.z.cols())
    throw UserError("{}: the true friction state has {} values, the oracle {} has {}", data.name,
                    z.cols(), model.name, driven.z.cols());
  Driven result{Transmission(model.arm.robot).torque_to_joints(driven.tau_f), {}};
  result.tau_f.rowwise() += constant_friction(model.arm.robot, known);
  for (const Start& from : starts)
    result.z0.emplace_back(z.row(from.begin).begin(), z.row(from.begin).end());
  return result;
}

std::vector<OpenLoop> open_loops(const Arm& arm, std::span<const Trajectory> trajectories,
                                 const Plan& plan, std::span<const Driven> driven) {
  std::vector<OpenLoop> loops;
  for (std::size_t i = 0; i < plan.starts.size(); ++i) {
    const auto of = static_cast<std::size_t>(plan.starts[i].trajectory);
    loops.push_back({.arm = &arm,
                     .trajectory = &trajectories[of],
                     .start = plan.starts[i],
                     .z0 = driven[of].z0[static_cast<std::size_t>(plan.rank[i])]});
  }
  return loops;
}

std::vector<Rollout> roll_out_batch(std::span<const OpenLoop> loops, std::span<const int> batch,
                                    const RolloutOptions& options) {
  std::vector<OpenLoop> own;
  for (const int i : batch) own.push_back(loops[static_cast<std::size_t>(i)]);
  return roll_out(own, options);
}

std::vector<Rollout> roll_out_many(std::span<const OpenLoop> loops, const RolloutOptions& options,
                                   int jobs) {
  std::vector<Start> starts;
  for (const OpenLoop& loop : loops) starts.push_back(loop.start);
  const std::vector<std::vector<int>> batches = batches_of(starts);
  std::vector<Rollout> rollouts(loops.size());
  parallel_for(static_cast<int>(batches.size()), jobs, [&](int b) {
    throw_if_stopped();
    const std::vector<int>& batch = batches[static_cast<std::size_t>(b)];
    std::vector<Rollout> made = roll_out_batch(loops, batch, options);
    for (std::size_t l = 0; l < batch.size(); ++l)
      rollouts[static_cast<std::size_t>(batch[l])] = std::move(made[l]);
  });
  return rollouts;
}

}  // namespace fricid::evaluate
