#include "fricid/evaluate/rollout.hpp"

#include <algorithm>
#include <cmath>

#include "fricid/base/error.hpp"
#include "fricid/system/transmission.hpp"

namespace fricid::evaluate {
namespace {

/// What one lane is fed and what it records, at the motors.
struct Lane {
  RowMatrix tau, temperature;  ///< (steps + 1, n)
  Rollout rollout;
};

Lane make_lane(const Trajectory& trajectory, const Start& start, const Transmission& motors) {
  const data::Dataset& data = trajectory.data;
  const Eigen::Index rows = start.steps + 1, n = data.n();
  Lane lane{motors.torque_to_motors(held_torque(data).middleRows(start.begin, rows)),
            RowMatrix::Constant(rows, n, kRoomTemperature),
            {start, false, RowMatrix(rows, n), RowMatrix(rows, n), RowMatrix(rows, n)}};
  if (data.temperature.size() > 0)
    lane.temperature = data.temperature.middleRows(start.begin, rows);
  return lane;
}

/// Adds a disturbance to the torque of sample k, at which the rollout has its velocity already.
/// @param exerted  what was added (n)
void disturb(Lane& lane, const RowMatrix& disturbance, Eigen::Index k, double slow_gain,
             Eigen::RowVectorXd& exerted) {
  for (Eigen::Index j = 0; j < lane.tau.cols(); ++j) {
    exerted[j] = disturbance_at(lane.rollout.v(k, j), disturbance(k, j), slow_gain);
    lane.tau(k, j) += exerted[j];
  }
}

/// Row `row` of a matrix into lane l of as many packs as it has columns, and back.
void load(const RowMatrix& matrix, Eigen::Index row, int l, std::vector<PackD>& packs) {
  for (std::size_t j = 0; j < packs.size(); ++j)
    set_lane(packs[j], l, matrix(row, static_cast<Eigen::Index>(j)));
}
void store(const std::vector<PackD>& packs, int l, Eigen::Index row, RowMatrix& matrix) {
  for (std::size_t j = 0; j < packs.size(); ++j)
    matrix(row, static_cast<Eigen::Index>(j)) = lane(packs[j], l);
}

void check_sizes(const Arm& arm, std::span<const Trajectory> trajectories,
                 std::span<const Start> starts, std::span<const std::vector<double>> z0,
                 std::span<const RowMatrix> disturbance) {
  if (!disturbance.empty() && disturbance.size() != starts.size())
    throw UserError("rollout: {} starts and {} disturbances, allowed equal numbers", starts.size(),
                    disturbance.size());
  if (starts.size() > PackD::kLanes || z0.size() != starts.size())
    throw UserError("rollout: {} starts and {} initial states, allowed equal numbers up to {}",
                    starts.size(), z0.size(), PackD::kLanes);
  for (std::size_t i = 0; i < starts.size(); ++i) {
    const Trajectory& trajectory = trajectories[static_cast<std::size_t>(starts[i].trajectory)];
    const data::Dataset& data = trajectory.data;
    if (data.n() != arm.robot.n())
      throw UserError("{}: {} joints, the model has {}", data.name, data.n(), arm.robot.n());
    if (std::ssize(z0[i]) != arm.friction.model.state_size())
      throw UserError("{}: initial friction state has {} values, the model {}", data.name,
                      z0[i].size(), arm.friction.model.state_size());
  }
}

bool has_diverged(const Rollout& rollout, const RowMatrix& reference, Eigen::Index k,
                  double limit) {
  for (Eigen::Index j = 0; j < rollout.q.cols(); ++j) {
    if (!std::isfinite(rollout.q(k, j)) || !std::isfinite(rollout.v(k, j))) return true;
    // a missing reference (NaN) is no divergence
    if (std::abs(rollout.q(k, j) - reference(rollout.start.begin + k, j)) > limit) return true;
  }
  return false;
}

}  // namespace

void settle_divergence(Rollout& rollout, const Trajectory& trajectory, double diverged_rad) {
  const RowMatrix& reference = trajectory.scored_q();
  const Eigen::Index rows = rollout.q.rows();
  Eigen::Index k = 1;
  while (k < rows && !has_diverged(rollout, reference, k, diverged_rad)) ++k;
  if (k >= rows) return;

  rollout.diverged = true;
  rollout.v.bottomRows(rows - k).setZero();
  if (rollout.tau_f.size() > 0) rollout.tau_f.bottomRows(rows - k).setZero();
  for (Eigen::Index i = k; i < rows; ++i)
    for (Eigen::Index j = 0; j < rollout.q.cols(); ++j) {
      const double last = rollout.q(k - 1, j), wanted = reference(rollout.start.begin + i, j);
      rollout.q(i, j) = std::isnan(wanted)
                            ? last
                            : std::clamp(last, wanted - diverged_rad, wanted + diverged_rad);
    }
}

std::vector<Rollout> roll_out(const Arm& arm, std::span<const Trajectory> trajectories,
                              std::span<const Start> starts,
                              std::span<const std::vector<double>> z0,
                              const RolloutOptions& options,
                              std::span<const RowMatrix> disturbance) {
  check_sizes(arm, trajectories, starts, z0, disturbance);
  if (starts.empty()) return {};
  const auto trajectory_of = [&](int l) -> const Trajectory& {
    const Start& start = starts[static_cast<std::size_t>(l)];
    return trajectories[static_cast<std::size_t>(start.trajectory)];
  };
  const double dt = trajectory_of(0).data.dt();
  const int count = static_cast<int>(starts.size());
  const auto n = static_cast<std::size_t>(arm.robot.n());
  const Transmission motors(arm.robot);

  std::vector<PackD> q(n, 0.0), v(n, 0.0), tau(n, 0.0), temperature(n, kRoomTemperature), tau_f(n);
  std::vector<PackD> z(static_cast<std::size_t>(arm.friction.model.state_size()), 0.0);
  std::vector<Lane> lanes;
  std::vector<Eigen::RowVectorXd> exerted(starts.size(), Eigen::RowVectorXd::Zero(arm.robot.n()));
  int longest = 0;
  for (int l = 0; l < count; ++l) {
    const auto i = static_cast<std::size_t>(l);
    lanes.push_back(make_lane(trajectory_of(l), starts[i], motors));
    longest = std::max(longest, starts[i].steps);
    load(motors.to_motors(trajectory_of(l).start_q().row(starts[i].begin)), 0, l, q);
    load(motors.to_motors(trajectory_of(l).start_v().row(starts[i].begin)), 0, l, v);
    for (std::size_t s = 0; s < z.size(); ++s) set_lane(z[s], l, z0[i][s]);
  }

  // A lane that has ended goes on under its last torque, unrecorded.
  ArmStepper<PackD> stepper(arm, options.step);
  for (int k = 0; k <= longest; ++k) {
    for (int l = 0; l < count; ++l) {
      Lane& lane = lanes[static_cast<std::size_t>(l)];
      if (k > lane.rollout.start.steps) continue;
      store(q, l, k, lane.rollout.q);
      store(v, l, k, lane.rollout.v);
      if (!disturbance.empty())
        disturb(lane, disturbance[static_cast<std::size_t>(l)], k, options.slow_gain,
                exerted[static_cast<std::size_t>(l)]);
      load(lane.tau, k, l, tau);
      load(lane.temperature, k, l, temperature);
    }
    stepper.friction_torque(tau, temperature, q, v, z, tau_f);
    for (int l = 0; l < count; ++l) {
      Rollout& rollout = lanes[static_cast<std::size_t>(l)].rollout;
      if (k > rollout.start.steps) continue;
      store(tau_f, l, k, rollout.tau_f);
      rollout.tau_f.row(k) -= exerted[static_cast<std::size_t>(l)];
    }
    if (k < longest) stepper.step(tau, temperature, dt, q, v, z);
  }

  std::vector<Rollout> rollouts;
  for (int l = 0; l < count; ++l) {
    Rollout& made = lanes[static_cast<std::size_t>(l)].rollout;
    if (motors.coupled()) {
      made.q = motors.to_joints(made.q);
      made.v = motors.to_joints(made.v);
      made.tau_f = motors.torque_to_joints(made.tau_f);
    }
    if (options.constant_friction.size() > 0) made.tau_f.rowwise() += options.constant_friction;
    rollouts.push_back(std::move(made));
    settle_divergence(rollouts.back(), trajectory_of(l), options.diverged_rad);
  }
  return rollouts;
}

}  // namespace fricid::evaluate
