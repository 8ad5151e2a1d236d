// Logs whose samples were not taken at even times, such as those of a loop that sleeps between
// them.
#pragma once

#include "fricid/data/dataset.hpp"

namespace fricid::data {

/// When the samples of a log with uneven stamps were taken.
enum class Taken {
  kAtStamps,  ///< the stamps are their times
  kEvenly,    ///< at even times, and stamped late
  kNotTold,   ///< the motion is as smooth by either
};

/// Which times make the motion smoother: each position is compared with the cubic through the two
/// samples before and after it, by the stamps and by even times, and the larger errors (upper
/// tenth) of tenths of the log by either decide where they differ by three standard errors.
/// @param d  neither rows whose stamps do not rise nor those beside longer pauses are looked at
Taken taken(const Dataset& d);

/// The log at even times of its rate from its first stamp on: positions and velocities on the cubic
/// through the two samples before and after, torques and temperatures on straight lines. Missing
/// between stamps that are more than 2.5 periods apart.
/// @throws UserError where fewer than 4 stamps rise
Dataset at_even_times(Dataset d);

}  // namespace fricid::data
