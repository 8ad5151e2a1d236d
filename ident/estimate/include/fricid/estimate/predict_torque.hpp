// The torque of a model along a measured motion.
#pragma once

#include "fricid/signals/recording.hpp"
#include "fricid/system/arm.hpp"

namespace fricid::estimate {

/// Torque that a model predicts along a measured motion, teacher forcing, at every row (T, n) [N
/// m], filtered at cutoff_hz like the `filtered_tau` of `measured`. The load of friction is that
/// torque itself (`drive_under_own_load`).
RowMatrix predict_torque(const Arm& arm, const signals::Recording& measured, double cutoff_hz);

}  // namespace fricid::estimate
