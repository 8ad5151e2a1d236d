// Whether a log shows that friction has a memory.
#pragma once

#include <span>

#include "fricid/estimate/friction/friction_fit.hpp"
#include "fricid/estimate/rigid_body/least_squares.hpp"
#include "fricid/signals/recording.hpp"

namespace fricid::estimate {

/// Whether a Dahl law explains more of what the rigid body leaves of a joint's torque than Coulomb
/// and viscous friction do: both fitted to the first four fifths of every recording and compared on
/// the rest, by more than the standard error over blocks of a second and by three tenths. Where the
/// rest has fewer than three blocks, each half of every recording is predicted from the other.
/// @param target  per recording, torque that the rigid body leaves (T, n) [N m]
bool shows_memory(std::span<const signals::Recording> recordings, const FrictionTorques& target,
                  const RigidBodyFit& rigid, int joint, double cutoff_hz);

}  // namespace fricid::estimate
