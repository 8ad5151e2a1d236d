#pragma once

namespace fricid::sim {

/// Motion before what is recorded [s]: long enough for the controller to settle and for bristles to
/// lose their initial state.
inline constexpr double kRunIn = 2.0;

}  // namespace fricid::sim
