// Friction state at the start of a recording.
#pragma once

#include <span>
#include <vector>

#include "fricid/system/arm.hpp"
#include "fricid/system/driven_friction.hpp"

namespace fricid {

/// Friction state at a time where only the friction torque is known. With hysteresis many states
/// give the same torque, so a likely past motion is assumed, joint by joint:
///
/// * a joint that moves, |v| > 0.02 rad/s, has been sliding at v;
/// * a joint at rest has slid in the direction of its torque, slowed down, and moved back until its
///   torque fell from the sliding torque to `tau_f`; where the sliding torque is smaller than
///   `tau_f`, it has slid on instead, up to 5 rad, which bends cables, and crept until static
///   friction held it.
///
/// The state of a law of the whole robot starts at zero.
///
/// @param in     motion, load and temperature at that moment (n)
/// @param tau_f  friction torque (n) [N m]
/// @return z (state_size); laws without memory have none
std::vector<double> state_at_torque(const friction::Friction& friction,
                                    std::span<const friction::Input<double>> in,
                                    std::span<const double> tau_f);

/// State at the first sample of a recording, from the measured torque less the rigid-body torque:
///
///     tau_f = mean of tau over the first 20 ms - rnea(q_0, v_0, a),   a = mean of dv/dt over them.
///
/// @param q, v         filtered motion (T, n)
/// @param tau          torque held after each sample (T, n) [N m]
/// @param temperature  (T, n) [K], or empty for room temperature
std::vector<double> initial_friction_state(const Arm& arm, double dt, ConstRowMatrix q,
                                           ConstRowMatrix v, ConstRowMatrix tau,
                                           ConstRowMatrix temperature);

}  // namespace fricid
