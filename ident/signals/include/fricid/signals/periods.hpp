// Motion that repeats: a model fitted to it has seen what comes again.
#pragma once

#include "fricid/signals/matrix.hpp"

namespace fricid::signals {

/// Samples after which a motion repeats, the fewest from four seconds on; 0: it does not. It does
/// where, over the moments at which the arm moves, the median of
///
///     rms_j (q_j(t + L) - q_j(t)) / sd_j
///
/// is below 0.05 at a minimum over the lag L, and was above 0.5 before: a log of less than 1.2
/// periods, or of a period above two minutes, does not show it.
/// @param q  (T, n) [rad or m]  @param dt  [s]
int period_of(ConstRowMatrix q, double dt);

/// Whether two recordings are of one motion: as long within 2 %, and the same median below 0.05.
bool is_same_motion(ConstRowMatrix a, ConstRowMatrix b);

}  // namespace fricid::signals
