#include "fricid/evaluate/rollout.hpp"

#include <algorithm>
#include <cmath>

#include "fricid/base/error.hpp"

namespace fricid::evaluate {
namespace {

using Row = Eigen::RowVectorXd;

/// One lane of a batch: what it is fed, what it has recorded, where it starts.
struct Lane {
  const Trajectory* trajectory;
  Start start;
  RowMatrix tau;          ///< (steps + 1, n) without gaps
  RowMatrix temperature;  ///< (steps + 1, n)
  Rollout rollout;
};

RowMatrix rows_of(const RowMatrix& matrix, const Start& start) {
  return matrix.middleRows(start.begin, start.steps + 1);
}

/// Repeats the last torque where one is missing; zero before the first.
void fill_gaps(RowMatrix& tau) {
  for (Eigen::Index j = 0; j < tau.cols(); ++j) {
    double last = 0;
    for (Eigen::Index k = 0; k < tau.rows(); ++k) {
      if (std::isfinite(tau(k, j))) last = tau(k, j);
      tau(k, j) = last;
    }
  }
}

Lane make_lane(const Trajectory& trajectory, const Start& start) {
  const Eigen::Index rows = start.steps + 1, n = trajectory.data.n();
  Lane lane{&trajectory,
            start,
            rows_of(trajectory.data.tau, start),
            RowMatrix::Constant(rows, n, kRoomTemperature),
            {}};
  fill_gaps(lane.tau);
  if (trajectory.data.temperature.size() > 0)
    lane.temperature = rows_of(trajectory.data.temperature, start);
  lane.rollout = {start, false, RowMatrix::Zero(rows, n), RowMatrix::Zero(rows, n),
                  RowMatrix::Zero(rows, n)};
  return lane;
}

bool has_diverged(const Row& q, const Row& v, const Lane& lane, int k, double limit) {
  if (!q.allFinite() || !v.allFinite()) return true;
  const Row error = q - lane.trajectory->scored_q().row(lane.start.begin + k);
  return (error.array().abs() > limit).any();  // a missing reference (NaN) accuses nobody
}

/// From sample k on the arm stands still where it last was, inside reference +- limit.
void stand_still(Lane& lane, int k, double limit) {
  Rollout& out = lane.rollout;
  out.diverged = true;
  const Row last = out.q.row(k - 1);
  for (int i = k; i <= lane.start.steps; ++i) {
    const auto reference = lane.trajectory->scored_q().row(lane.start.begin + i);
    for (Eigen::Index j = 0; j < last.size(); ++j)
      out.q(i, j) = std::isnan(reference[j])
                        ? last[j]
                        : std::clamp(last[j], reference[j] - limit, reference[j] + limit);
  }
}

/// States of all lanes as the stepper wants them.
struct Batch {
  std::vector<PackD> q, v, z, tau, temperature, tau_f;
  Batch(std::size_t n, std::size_t nz)
      : q(n, 0), v(n, 0), z(nz, 0), tau(n, 0), temperature(n, kRoomTemperature), tau_f(n, 0) {}
};

void load_state(Batch& batch, int l, const Row& q, const Row& v, std::span<const double> z) {
  for (std::size_t j = 0; j < batch.q.size(); ++j) {
    set_lane(batch.q[j], l, q[static_cast<Eigen::Index>(j)]);
    set_lane(batch.v[j], l, v[static_cast<Eigen::Index>(j)]);
  }
  for (std::size_t i = 0; i < batch.z.size(); ++i) set_lane(batch.z[i], l, z[i]);
}

void load_inputs(Batch& batch, int l, const Lane& lane, int k) {
  for (std::size_t j = 0; j < batch.q.size(); ++j) {
    const auto col = static_cast<Eigen::Index>(j);
    set_lane(batch.tau[j], l, lane.tau(k, col));
    set_lane(batch.temperature[j], l, lane.temperature(k, col));
  }
}

Row lane_of(const std::vector<PackD>& packs, int l) {
  Row row(static_cast<Eigen::Index>(packs.size()));
  for (std::size_t j = 0; j < packs.size(); ++j) row[static_cast<Eigen::Index>(j)] = packs[j][l];
  return row;
}

void check_sizes(const Arm& arm, std::span<const Trajectory> trajectories,
                 std::span<const Start> starts, std::span<const std::vector<double>> z0) {
  if (starts.size() > PackD::kLanes || z0.size() != starts.size())
    throw UserError("rollout: {} starts and {} initial states, allowed equal numbers up to {}",
                    starts.size(), z0.size(), PackD::kLanes);
  for (std::size_t i = 0; i < starts.size(); ++i) {
    const Trajectory& trajectory = trajectories[static_cast<std::size_t>(starts[i].trajectory)];
    if (trajectory.data.n() != arm.robot.n())
      throw UserError("{}: {} joints, the model has {}", trajectory.data.name, trajectory.data.n(),
                      arm.robot.n());
    if (std::ssize(z0[i]) != arm.friction.model.state_size())
      throw UserError("{}: initial friction state has {} values, the model {}",
                      trajectory.data.name, z0[i].size(), arm.friction.model.state_size());
  }
}

}  // namespace

std::vector<Rollout> roll_out(const Arm& arm, std::span<const Trajectory> trajectories,
                              std::span<const Start> starts,
                              std::span<const std::vector<double>> z0,
                              const RolloutOptions& options) {
  check_sizes(arm, trajectories, starts, z0);
  const auto n = static_cast<std::size_t>(arm.robot.n());
  const auto nz = static_cast<std::size_t>(arm.friction.model.state_size());
  ArmStepper<PackD> stepper(arm, options.step);
  Batch batch(n, nz);
  std::vector<Lane> lanes;
  int longest = 0;
  for (const Start& start : starts) {
    lanes.push_back(make_lane(trajectories[static_cast<std::size_t>(start.trajectory)], start));
    longest = std::max(longest, start.steps);
  }

  // A lane without a rollout, or one that has ended, stands at its start.
  const auto restart = [&](int l) {
    const Lane& lane = lanes[static_cast<std::size_t>(l)];
    load_state(batch, l, lane.trajectory->start_q().row(lane.start.begin),
               lane.trajectory->start_v().row(lane.start.begin), z0[static_cast<std::size_t>(l)]);
    load_inputs(batch, l, lane, 0);
  };
  for (int l = 0; l < std::ssize(lanes); ++l) restart(l);

  for (int k = 0; k <= longest; ++k) {
    for (int l = 0; l < std::ssize(lanes); ++l) {
      Lane& lane = lanes[static_cast<std::size_t>(l)];
      if (lane.rollout.diverged || k > lane.start.steps) {
        restart(l);
        continue;
      }
      load_inputs(batch, l, lane, k);
      const Row q = lane_of(batch.q, l), v = lane_of(batch.v, l);
      if (k > 0 && has_diverged(q, v, lane, k, options.diverged_rad)) {
        stand_still(lane, k, options.diverged_rad);
        continue;
      }
      lane.rollout.q.row(k) = q;
      lane.rollout.v.row(k) = v;
    }
    stepper.friction_torque(batch.tau, batch.temperature, batch.q, batch.v, batch.z, batch.tau_f);
    for (int l = 0; l < std::ssize(lanes); ++l) {
      Lane& lane = lanes[static_cast<std::size_t>(l)];
      if (!lane.rollout.diverged && k <= lane.start.steps)
        lane.rollout.tau_f.row(k) = lane_of(batch.tau_f, l);
    }
    if (k < longest)
      stepper.step(batch.tau, batch.temperature, trajectories.front().data.dt(), batch.q, batch.v,
                   batch.z);
  }

  std::vector<Rollout> rollouts;
  for (Lane& lane : lanes) rollouts.push_back(std::move(lane.rollout));
  return rollouts;
}

}  // namespace fricid::evaluate
