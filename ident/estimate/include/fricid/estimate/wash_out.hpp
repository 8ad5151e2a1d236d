// The friction state of an arm along recorded motion.
#pragma once

#include <span>
#include <vector>

#include "fricid/signals/recording.hpp"
#include "fricid/system/arm.hpp"

namespace fricid::estimate {

/// Friction state of a model along every recording, washed out by the motion of one band: (T,
/// state_size) each, from `initial_friction_state` on. Steps as `drive_friction` does, but in
/// pieces of 4 s side by side, each begun 4 s earlier: after that much motion a joint no longer
/// depends on the friction state it started with. A law of the whole robot is driven through each
/// recording in one piece.
std::vector<RowMatrix> wash_out(const Arm& arm, std::span<const signals::Recording> recordings,
                                int jobs, signals::Band band = signals::Band::kWide);

}  // namespace fricid::estimate
