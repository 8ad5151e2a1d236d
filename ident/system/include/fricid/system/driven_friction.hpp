// Friction driven by a measured motion (teacher forcing), for washout and starting states.
#pragma once

#include <functional>
#include <span>
#include <vector>

#include "fricid/friction/robot_friction.hpp"
#include "fricid/signals/matrix.hpp"

namespace fricid {

/// Friction torque and state along a motion.
struct DrivenFriction {
  RowMatrix tau_f;  ///< (T, n) [N m], at the samples
  RowMatrix z;      ///< (T, state_size), at the samples
};

/// Friction that follows a motion sample by sample, its state never corrected by a torque. Keeps a
/// reference to the friction; does not allocate after it was made.
class FrictionFollower {
 public:
  /// @param z0  state at the first sample (state_size); empty: zero
  FrictionFollower(const friction::Friction& friction, double dt, std::span<const double> z0 = {});

  /// Moves the state to the next sample, the mean velocity held in between, and gives the torque
  /// there (n) [N m], valid until the next call; see drive_friction. The first call only gives it.
  /// @param q, v, load, temperature  at that sample (n) [rad], [rad/s], [N m], [K]
  std::span<const double> follow(std::span<const double> q, std::span<const double> v,
                                 std::span<const double> load, std::span<const double> temperature);

  std::span<const double> z() const { return z_; }

 private:
  const friction::Friction& friction_;
  double dt_;
  bool begun_ = false;
  std::vector<friction::Input<double>> in_;
  std::vector<double> z_, tau_f_;
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

/// Friction along a motion under the load that the model itself predicts, rigid + tau_f: first with
/// the torque of the rigid body as load and, where a law reads the load, again with that plus the
/// friction found, until the friction of each joint changes by less than 1e-4 of its size (30 times
/// at most). The measured torque would bring in what the model leaves unexplained.
///
/// @param rigid   torque of the rigid body (T, n) [N m]
/// @param filter  what the friction torque passes through on its way into the load and the result,
///                like the measured torque; empty: nothing
/// @throws UserError as `drive_friction`
DrivenFriction drive_under_own_load(const friction::Friction& friction, double dt, ConstRowMatrix q,
                                    ConstRowMatrix v, ConstRowMatrix rigid,
                                    ConstRowMatrix temperature, std::span<const double> z0 = {},
                                    const std::function<void(RowMatrix&)>& filter = {});

}  // namespace fricid
