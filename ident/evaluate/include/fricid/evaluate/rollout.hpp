// Open-loop rollouts of one arm, many at once: lanes of a Pack are rollouts.
#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "fricid/evaluate/trajectory.hpp"
#include "fricid/system/arm.hpp"

namespace fricid::evaluate {

/// Motion of an arm under the measured torque alone.
struct Rollout {
  Start start;
  bool diverged = false;
  RowMatrix q;      ///< (steps + 1, n) [rad]
  RowMatrix v;      ///< (steps + 1, n) [rad/s]
  RowMatrix tau_f;  ///< (steps + 1, n) [N m], or empty where it is not known
};

struct RolloutOptions {
  StepOptions step;
  double diverged_rad = 10;  ///< largest |q error| of a joint that still counts as a rollout
  double slow_gain = 0;      ///< of a disturbance, see disturbance_at
  Eigen::RowVectorXd constant_friction = {};  ///< (n) in the recorded tau_f [N m]; empty: none
};

/// Flags a rollout whose state is no longer finite or whose position error exceeds `diverged_rad`
/// at any joint. From that sample on the arm stands still (v = 0, tau_f = 0) at its last position,
/// clamped to the scored position +- diverged_rad: its figures stay finite.
void settle_divergence(Rollout& rollout, const Trajectory& trajectory, double diverged_rad);

inline constexpr double kSlow = 0.1;  ///< [rad/s]

/// Torque that a disturbance e exerts on a joint of speed v [N m]: larger at rest,
///
///     e (1 + slow_gain / (1 + (v/kSlow)^2)).
inline double disturbance_at(double v, double e, double slow_gain) {
  return e * (1 + slow_gain / (1 + v * v / (kSlow * kSlow)));
}

/// Rolls an arm out from (start_q, start_v, z0) with the measured torque held over each sample, and
/// settles what diverged.
/// @param starts       at most as many as PackD has lanes; one lane each, the same whatever the
///                     others do
/// @param z0           initial friction state of each rollout (state_size)
/// @param disturbance  what moves the arm besides the measured torque, (steps + 1, n) for each
///                     rollout [N m], see disturbance_at; it counts as friction and is taken from
///                     the recorded tau_f. Empty: none
/// @throws UserError when sizes do not agree
std::vector<Rollout> roll_out(const Arm& arm, std::span<const Trajectory> trajectories,
                              std::span<const Start> starts,
                              std::span<const std::vector<double>> z0,
                              const RolloutOptions& options,
                              std::span<const RowMatrix> disturbance = {});

/// Writes HDF5, format "fricid.rollout/1": /t (s), /q, /v [, /tau_f] with attribute `unit`; root
/// attributes format, joint_names, model, seed, trajectory. Atomic.
void save_rollout(const Rollout& rollout, const Trajectory& trajectory, const std::string& model,
                  int seed, const std::filesystem::path& path);

/// What such a file holds.
struct RolloutSignals {
  Eigen::VectorXd t;  ///< (T) [s]
  RowMatrix q;        ///< (T, n) [rad]
  RowMatrix v;        ///< (T, n) [rad/s]
  RowMatrix tau_f;    ///< (T, n) [N m], or empty where it is not known
};
/// @param n  number of joints
/// @throws UserError naming the file when it is missing, of another format, or a table is not (T,
/// n)
RolloutSignals load_rollout(const std::filesystem::path& path, int n);

}  // namespace fricid::evaluate
