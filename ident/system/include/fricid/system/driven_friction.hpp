// Friction driven by a measured motion (teacher forcing), for washout and starting states.
#pragma once

#include <span>

#include "fricid/friction/robot_friction.hpp"
#include "fricid/signals/matrix.hpp"

namespace fricid {

/// Friction torque and state along a motion.
struct DrivenFriction {
  RowMatrix tau_f;  ///< (T, n) [N m], at the samples
  RowMatrix z;      ///< (T, state_size), at the samples
};

/// Friction along a measured motion, in open loop: the measured torque never corrects the state.
/// The mean velocity is held over each sample, as the step of a law assumes:
///
///     tau_f,k = torque(theta; q_k, v_k, load_k, temperature_k, z_k)
///     z_{k+1} = step(theta; q_{k+1}, (q_{k+1} - q_k) / dt, load_k, temperature_k, dt, z_k).
///
/// An open-loop rollout from sample k may start with row k of z: an error of z_0 decays within a
/// few bristle lengths of travel.
///
/// @param q, v, load   motion (T, n) [rad], [rad/s] and torque through the gear [N m]
/// @param temperature  (T, n) [K], or empty for room temperature
/// @param z0           state at the first sample (state_size); empty: zero
/// @throws UserError if the sizes do not agree
DrivenFriction drive_friction(const friction::Friction& friction, double dt, ConstRowMatrix q,
                              ConstRowMatrix v, ConstRowMatrix load, ConstRowMatrix temperature,
                              std::span<const double> z0 = {});

}  // namespace fricid
