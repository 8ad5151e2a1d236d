// Open-loop rollouts, many at once: lanes of a Pack are rollouts.
#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "fricid/base/field.hpp"
#include "fricid/evaluate/trajectory.hpp"
#include "fricid/system/arm.hpp"

namespace fricid::evaluate {

/// Motion of an arm under the measured torque alone.
struct Rollout {
  Start start;
  bool diverged = false;
  RowMatrix q;      ///< (steps + 1, n) [rad]
  RowMatrix v;      ///< (steps + 1, n) [rad/s]
  RowMatrix tau_f;  ///< (steps + 1, n) [N m]; empty: unknown
};

struct RolloutOptions {
  StepOptions step;
  double diverged_rad = 10;  ///< largest |q error| of a joint that still counts as a rollout
  double slow_gain = 0;      ///< of a disturbance, see disturbance_at
  Eigen::RowVectorXd constant_friction = {};  ///< (n) in the recorded tau_f [N m]; empty: none
};

/// Flags a rollout whose state is no longer finite or whose position error exceeds `diverged_rad`
/// at any joint. From that sample on the arm is held (v = 0, tau_f = 0) at its last position,
/// clamped to the scored position +- diverged_rad: its figures stay finite.
void settle_divergence(Rollout& rollout, const Trajectory& trajectory, double diverged_rad);

inline constexpr double kSlow = 0.1;  ///< [rad/s]

/// Torque that a disturbance e exerts on a motor of speed v [N m]: larger at rest,
///
///     e (1 + slow_gain / (1 + (v/kSlow)^2)).
inline double disturbance_at(double v, double e, double slow_gain) {
  return e * (1 + slow_gain / (1 + v * v / (kSlow * kSlow)));
}

/// One open loop to make.
struct OpenLoop {
  const Arm* arm;
  const Trajectory* trajectory;
  Start start;                 ///< Start::trajectory is handed on
  std::span<const double> z0;  ///< initial friction state (state_size)
  /// what moves the arm besides the measured torque, (steps + 1, n) [N m], see disturbance_at; it
  /// counts as friction and is taken from the recorded tau_f. Null: none
  const RowMatrix* disturbance = nullptr;
};

/// Rolls arms out from (start_q, start_v, z0) with the measured torque held over each sample, and
/// settles what diverged.
/// @param loops  at most as many as PackD has lanes; one lane each, the same whatever the others
///               do. Their arms differ in parameters alone, their recordings have one sample period
/// @throws UserError when sizes do not agree
std::vector<Rollout> roll_out(std::span<const OpenLoop> loops, const RolloutOptions& options);

/// A rollout as a file.
struct RolloutSignals {
  static constexpr std::string_view kFormat = "fricid.rollout/1";

  std::vector<std::string> joint_names;  ///< (n)
  std::string model, trajectory;         ///< names
  double seed = 1;                       ///< of the model's fit
  double diverged = 0;                   ///< 1: diverged, constant from there
  Eigen::VectorXd t;                     ///< (T) [s]
  RowMatrix q;                           ///< (T, n) [rad]
  RowMatrix v;                           ///< (T, n) [rad/s]
  RowMatrix tau_f;                       ///< (T, n) [N m]; empty: unknown

  template <class Archive>
  void visit(Archive& archive) {
    archive.joints(joint_names);
    archive.stamp("model", model, text("name of the model"));
    archive.stamp("seed", seed, number("", 0, 1e9, "seed of the fit"));
    archive.stamp("trajectory", trajectory, text("recording whose torque drove it"));
    archive.stamp("diverged", diverged, number("", 0, 1, "1: diverged, constant from there"));
    archive.times(t);
    archive.of_joints("q", q, signal("rad", "position"));
    archive.of_joints("v", v, signal("rad/s", "velocity"));
    archive.of_joints_or_none("tau_f", tau_f, signal("N m", "friction torque"));
  }
};
void save_rollout(const Rollout& rollout, const Trajectory& trajectory, const std::string& model,
                  int seed, const std::filesystem::path& path);
/// @param n  number of joints
/// @throws as data::load_signals
RolloutSignals load_rollout(const std::filesystem::path& path, int n);

}  // namespace fricid::evaluate
