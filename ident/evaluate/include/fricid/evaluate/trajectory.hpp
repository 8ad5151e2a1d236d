// Held-out recordings and the open-loop rollouts to make on them.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "fricid/data/dataset.hpp"
#include "fricid/system/driven_friction.hpp"

namespace fricid::evaluate {

/// True signals of a simulated recording, at its samples.
struct Reference {
  RowMatrix q;      ///< (T, n) [rad]
  RowMatrix v;      ///< (T, n) [rad/s]
  RowMatrix tau_f;  ///< (T, n) [N m]
  RowMatrix
      z;  ///< (T, state_size) of the injected friction, or empty; only the oracle starts from it
};

/// A held-out recording. A model sees `data.tau` (held), `data.temperature` and the filtered motion
/// up to its start; it is scored against `truth`, or against the measurement without one.
struct Trajectory {
  data::Dataset data;
  RowMatrix q;  ///< (T, n) zero-phase filtered position [rad]
  RowMatrix v;  ///< (T, n) its derivative [rad/s]
  RowMatrix a;  ///< (T, n) its second derivative [rad/s^2]; empty: no torque is predicted
  std::optional<Reference> truth;
  Eigen::VectorXd q_sd{};  ///< (n) noise of data.q, standard deviation [rad]; empty: none

  const RowMatrix& scored_q() const { return truth ? truth->q : data.q; }
  /// Of the noise of `scored_q` of joint j [rad].
  double scored_q_sd(Eigen::Index j) const { return truth || q_sd.size() == 0 ? 0 : q_sd[j]; }
  const RowMatrix& scored_v() const { return truth ? truth->v : v; }
  const RowMatrix& start_q() const { return truth ? truth->q : q; }
  const RowMatrix& start_v() const { return truth ? truth->v : v; }
};

/// Samples [begin, end) of a trajectory, without its truth.
Trajectory part_of(const Trajectory& whole, int begin, int end);

/// Measured torque (T, n) [N m] with missing (NaN) values replaced by the last one, zero before the
/// first.
RowMatrix held_torque(const data::Dataset& dataset);

/// One open-loop rollout: from sample `begin` of a trajectory over `steps` samples.
struct Start {
  int trajectory = 0;
  int begin = 0;
  int steps = 0;
};

/// Number of samples in a horizon [s] of a trajectory of T samples at dt; 0 means full length, T
/// - 1.
int horizon_steps(double horizon_s, double dt, int T);

/// Rollouts of every trajectory: one from its first sample over the longest horizon (0: full
/// length), and `starts` more, evenly spread and ending with the recording, over the longest finite
/// horizon that leaves room for them.
std::vector<Start> plan_starts(std::span<const Trajectory> trajectories,
                               std::span<const double> horizons_s, int starts);

}  // namespace fricid::evaluate
