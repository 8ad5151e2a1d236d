// Recordings of motion that repeats, cut into periods.
#pragma once

#include <span>
#include <vector>

#include "fricid/signals/recording.hpp"

namespace fricid::estimate {

/// Where a cut recording was in those that were given.
struct Origin {
  int recording = 0, begin = 0;
};

struct ByPeriod {
  std::vector<signals::Recording> recordings;
  std::vector<Origin> origins;  ///< of each
  double longest_s = 0;         ///< longest period; 0: no motion repeats
};

/// Each recording whose motion repeats (`signals::mark_repeats`) as recordings of one period each,
/// what is left over at its end left out. The end of a recording is held out from training; of one
/// of several periods it is motion that training has seen, and laws that fit that path alone,
/// ripples of the angle above all, would be as good there as the right one. Cut, the same phase is
/// held out of every period.
ByPeriod by_period(std::span<const signals::Recording> recordings);

}  // namespace fricid::estimate
