// Friction driven by given motion instead of by the arm's own: washout and teacher forcing.
#pragma once

#include <Eigen/Core>
#include <span>

#include "fricid/friction/robot_friction.hpp"

namespace fricid {

using RowMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
using ConstRowMatrix = Eigen::Ref<const RowMatrix>;

/// Friction torque and state along a motion.
struct DrivenFriction {
  RowMatrix tau_f;  ///< (T, n) [N m], at the samples
  RowMatrix z;      ///< (T, state_size), at the samples
};

/// Friction along a measured motion: the state is washed out by it, never corrected by torque. With
/// the mean velocity held over each sample, as the step of a law wants it,
///
///     tau_f,k = torque(theta; q_k, v_k, load_k, temperature_k, z_k)
///     z_{k+1} = step(theta; q_{k+1}, (q_{k+1} - q_k) / dt, load_k, temperature_k, dt, z_k).
///
/// Row k of z is the state with which an open-loop rollout may start at sample k: what of z_0 was
/// wrong has been forgotten after a few bristle lengths of travel.
///
/// @param q, v, load   motion (T, n) [rad], [rad/s] and torque through the gear [N m]
/// @param temperature  (T, n) [K], or empty for room temperature
/// @param z0           state at the first sample (state_size); empty: zero
/// @throws UserError when the sizes do not agree
DrivenFriction drive_friction(const friction::Friction& friction, double dt, ConstRowMatrix q,
                              ConstRowMatrix v, ConstRowMatrix load, ConstRowMatrix temperature,
                              std::span<const double> z0 = {});

}  // namespace fricid
