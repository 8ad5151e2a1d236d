// The starts of an evaluation, cut into lanes, and a model's rollouts from them.
#pragma once

#include <span>
#include <vector>

#include "fricid/data/model_file.hpp"
#include "fricid/evaluate/options.hpp"
#include "fricid/evaluate/rollout.hpp"

namespace fricid::evaluate {

/// Everything that is fixed before the first rollout. Depends on recordings and options alone.
struct Plan {
  std::vector<Start> starts;
  std::vector<std::vector<int>> batches;  ///< starts that run together, the longest first
  std::vector<std::vector<Start>> by_trajectory;
  std::vector<int> rank;  ///< of each start within its trajectory
};

Plan make_plan(std::span<const Trajectory> trajectories, const EvaluateOptions& options);

/// Friction of one model driven by the measured motion of one trajectory.
struct Driven {
  RowMatrix tau_f;                      ///< (T, n); empty for rollouts that come from elsewhere
  std::vector<std::vector<double>> z0;  ///< state at each planned start of the trajectory
};

/// @param known  the robot before identification, see constant_friction
Driven drive(const data::ModelFile& model, const dynamics::RobotModel& known,
             const Trajectory& trajectory, std::span<const Start> starts);

/// Rollouts of one batch of the plan, in its order.
/// @param driven       one per trajectory
/// @param disturbance  one per start of the plan, see roll_out; empty: none
std::vector<Rollout> roll_out_batch(const Arm& arm, std::span<const Trajectory> trajectories,
                                    const Plan& plan, std::span<const int> batch,
                                    std::span<const Driven> driven, const RolloutOptions& options,
                                    std::span<const RowMatrix> disturbance = {});

}  // namespace fricid::evaluate
