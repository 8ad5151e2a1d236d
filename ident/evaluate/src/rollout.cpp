#include "fricid/evaluate/rollout.hpp"

#include <algorithm>
#include <cmath>

#include "fricid/base/error.hpp"
#include "fricid/system/transmission.hpp"

namespace fricid::evaluate {
namespace {

/// What one lane is fed and what it records, at the motors.
struct Lane {
  const OpenLoop* loop;
  RowMatrix tau, temperature;  ///< (steps + 1, n)
  Rollout rollout;
  Eigen::RowVectorXd exerted;  ///< of the disturbance at the present sample (n)

  int steps() const { return loop->start.steps; }
};

Lane make_lane(const OpenLoop& loop, const Transmission& motors) {
  const data::Dataset& data = loop.trajectory->data;
  const Eigen::Index begin = loop.start.begin, rows = loop.start.steps + 1, n = data.n();
  Lane lane{&loop,
            motors.torque_to_motors(held_torque(data).middleRows(begin, rows)),
            RowMatrix::Constant(rows, n, kRoomTemperature),
            {loop.start, false, RowMatrix(rows, n), RowMatrix(rows, n), RowMatrix(rows, n)},
            Eigen::RowVectorXd::Zero(n)};
  if (data.temperature.size() > 0) lane.temperature = data.temperature.middleRows(begin, rows);
  return lane;
}

/// Adds the disturbance to the torque of sample k, at which the rollout has its velocity already.
void disturb(Lane& lane, Eigen::Index k, double slow_gain) {
  for (Eigen::Index j = 0; j < lane.tau.cols(); ++j) {
    lane.exerted[j] =
        disturbance_at(lane.rollout.v(k, j), (*lane.loop->disturbance)(k, j), slow_gain);
    lane.tau(k, j) += lane.exerted[j];
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

void check_sizes(std::span<const OpenLoop> loops) {
  if (loops.size() > PackD::kLanes)
    throw UserError("rollout: {} open loops, allowed up to {}", loops.size(), PackD::kLanes);
  const Arm& first = *loops.front().arm;
  for (const OpenLoop& loop : loops) {
    const data::Dataset& data = loop.trajectory->data;
    if (data.n() != loop.arm->robot.n())
      throw UserError("{}: {} joints, the model has {}", data.name, data.n(), loop.arm->robot.n());
    if (std::ssize(loop.z0) != loop.arm->friction.model.state_size())
      throw UserError("{}: initial friction state has {} values, the model {}", data.name,
                      loop.z0.size(), loop.arm->friction.model.state_size());
    if (loop.arm->robot.pi.size() != first.robot.pi.size() ||
        loop.arm->friction.theta.size() != first.friction.theta.size())
      throw UserError("{}: an arm with {} + {} parameters beside one with {} + {}", data.name,
                      loop.arm->robot.pi.size(), loop.arm->friction.theta.size(),
                      first.robot.pi.size(), first.friction.theta.size());
  }
}

/// Gives every lane of the stepper its own arm's parameters.
void set_parameters(std::span<const OpenLoop> loops, ArmStepper<PackD>& stepper) {
  const auto in_lanes = [&](const auto& values_of) {
    const auto& first = values_of(*loops.front().arm);
    std::vector<PackD> packs(first.begin(), first.end());
    for (std::size_t l = 0; l < loops.size(); ++l)
      for (std::size_t i = 0; const double value : values_of(*loops[l].arm))
        set_lane(packs[i++], static_cast<int>(l), value);
    return packs;
  };
  const std::vector<PackD> pi = in_lanes([](const Arm&arm) -> auto& { return arm.robot.pi; }),
                           theta =
                               in_lanes([](const Arm&arm) -> auto& { return arm.friction.theta; });
  stepper.set_parameters(pi, theta);
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

std::vector<Rollout> roll_out(std::span<const OpenLoop> loops, const RolloutOptions& options) {
  if (loops.empty()) return {};
  check_sizes(loops);
  const Arm& arm = *loops.front().arm;
  const double dt = loops.front().trajectory->data.dt();
  const auto n = static_cast<std::size_t>(arm.robot.n());
  const Transmission motors(arm.robot);

  std::vector<PackD> q(n, 0.0), v(n, 0.0), tau(n, 0.0), temperature(n, kRoomTemperature), tau_f(n);
  std::vector<PackD> z(static_cast<std::size_t>(arm.friction.model.state_size()), 0.0);
  std::vector<Lane> lanes;
  int longest = 0;
  for (const OpenLoop& loop : loops) {
    const auto l = static_cast<int>(lanes.size());
    lanes.push_back(make_lane(loop, motors));
    longest = std::max(longest, loop.start.steps);
    load(motors.to_motors(loop.trajectory->start_q().row(loop.start.begin)), 0, l, q);
    load(motors.to_motors(loop.trajectory->start_v().row(loop.start.begin)), 0, l, v);
    for (std::size_t s = 0; s < z.size(); ++s) set_lane(z[s], l, loop.z0[s]);
  }

  // A lane that has ended goes on under its last torque, unrecorded.
  ArmStepper<PackD> stepper(arm, options.step);
  set_parameters(loops, stepper);
  for (int k = 0; k <= longest; ++k) {
    for (int l = 0; Lane & lane : lanes) {
      if (k <= lane.steps()) {
        store(q, l, k, lane.rollout.q);
        store(v, l, k, lane.rollout.v);
        if (lane.loop->disturbance != nullptr) disturb(lane, k, options.slow_gain);
        load(lane.tau, k, l, tau);
        load(lane.temperature, k, l, temperature);
      }
      ++l;
    }
    stepper.friction_torque(tau, temperature, q, v, z, tau_f);
    for (int l = 0; Lane & lane : lanes) {
      if (k <= lane.steps()) {
        store(tau_f, l, k, lane.rollout.tau_f);
        lane.rollout.tau_f.row(k) -= lane.exerted;
      }
      ++l;
    }
    if (k < longest) stepper.step(tau, temperature, dt, q, v, z);
  }

  std::vector<Rollout> rollouts;
  for (Lane& lane : lanes) {
    Rollout& made = rollouts.emplace_back(std::move(lane.rollout));
    if (motors.coupled()) {
      made.q = motors.to_joints(made.q);
      made.v = motors.to_joints(made.v);
      made.tau_f = motors.torque_to_joints(made.tau_f);
    }
    if (options.constant_friction.size() > 0) made.tau_f.rowwise() += options.constant_friction;
    settle_divergence(made, *lane.loop->trajectory, options.diverged_rad);
  }
  return rollouts;
}

}  // namespace fricid::evaluate
