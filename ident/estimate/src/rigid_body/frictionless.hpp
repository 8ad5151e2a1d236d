// A torque in which no joint has friction.
#pragma once

#include <span>

#include "fricid/estimate/rigid_body/least_squares.hpp"
#include "fricid/signals/recording.hpp"

namespace fricid::estimate {

/// Whether Coulomb and viscous friction of every joint are, at its mean speed, less than a
/// hundredth of its torque (rms) or within four standard errors of none, and known to a tenth: no
/// gear is, but a torque is that was computed from the motion. @param fit  of all joints
bool is_frictionless(std::span<const signals::Recording> recordings, const RigidBodyFit& fit);

}  // namespace fricid::estimate
