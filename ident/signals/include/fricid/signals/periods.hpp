// Motion that repeats: a model fitted to it has seen what comes again.
#pragma once

#include <span>

#include "fricid/signals/matrix.hpp"
#include "fricid/signals/recording.hpp"

namespace fricid::signals {

/// What is looked for: a period shorter than four seconds leaves no motion to hold out.
struct PeriodRange {
  double shortest_s = 4, longest_s = 120;  ///< [s]
  double least_count = 1.2;                ///< of periods in the log
};

/// Samples after which a motion repeats, the fewest in a range; 0: it does not. It does where, over
/// the moments at which the arm moves, the median of
///
///     rms_j (q_j(t + L) - q_j(t)) / sd_j
///
/// is below 0.05 at a minimum over the lag L, and was above 0.5 before.
/// @param q  (T, n), missing values NaN [rad or m]  @param dt  [s]
int period_of(ConstRowMatrix q, double dt, const PeriodRange& range = {});

/// Whether two recordings are of one motion: as long within 2 %, and the same median below 0.05.
bool is_same_motion(ConstRowMatrix a, ConstRowMatrix b);

/// Sets `motion_number` of recordings (`is_same_motion`), from 0 in the order of their first.
void number_motions(std::span<Recording> recordings);

/// Sets `motion_number` and `period` of recordings. What a model leaves of the torque comes again
/// with the motion, so that passages of one motion count as one where errors are judged.
void mark_repeats(std::span<Recording> recordings, int jobs);

}  // namespace fricid::signals
