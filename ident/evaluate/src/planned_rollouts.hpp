// The starts of an evaluation, cut into lanes, and rollouts from them.
#pragma once

#include <span>
#include <vector>

#include "fricid/data/model_file.hpp"
#include "fricid/evaluate/options.hpp"
#include "fricid/evaluate/rollout.hpp"

namespace fricid::evaluate {

/// Lanes that run together: indices of starts, the longest rollouts first. Depends on the starts
/// alone.
std::vector<std::vector<int>> batches_of(std::span<const Start> starts);

/// Everything that is fixed before the first rollout. Depends on recordings and options alone.
struct Plan {
  std::vector<Start> starts;
  std::vector<std::vector<int>> batches;  ///< of the starts
  std::vector<std::vector<Start>> by_trajectory;
  std::vector<int> rank;  ///< of each start within its trajectory
};

Plan make_plan(std::span<const Trajectory> trajectories, const EvaluateOptions& options);

/// Friction of one model driven by the measured motion of one trajectory.
struct Driven {
  RowMatrix tau_f;                      ///< (T, n); empty for rollouts that come from elsewhere
  std::vector<std::vector<double>> z0;  ///< state at each planned start of the trajectory
};

/// Friction state of an arm at the first sample of a recording, see initial_friction_state.
std::vector<double> first_state(const Arm& arm, const Trajectory& trajectory);

/// @param known  the robot before identification, see constant_friction
Driven drive(const data::ModelFile& model, const dynamics::RobotModel& known,
             const Trajectory& trajectory, std::span<const Start> starts);

/// The open loops of a plan, one per start. They refer to the arguments.
/// @param driven  one per trajectory
std::vector<OpenLoop> open_loops(const Arm& arm, std::span<const Trajectory> trajectories,
                                 const Plan& plan, std::span<const Driven> driven);

/// Rollouts of those loops that a batch names, in its order.
std::vector<Rollout> roll_out_batch(std::span<const OpenLoop> loops, std::span<const int> batch,
                                    const RolloutOptions& options);

/// Rollouts of any number of loops, in their order; the same for any `jobs`.
std::vector<Rollout> roll_out_many(std::span<const OpenLoop> loops, const RolloutOptions& options,
                                   int jobs);

}  // namespace fricid::evaluate
