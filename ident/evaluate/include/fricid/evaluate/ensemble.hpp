// The seeds of one model as an ensemble: its mean and its 90 % band.
#pragma once

#include <span>
#include <vector>

#include "fricid/evaluate/rollout.hpp"
#include "fricid/evaluate/trajectory.hpp"

namespace fricid::evaluate {

/// An ensemble over the samples from the first one to a horizon.
struct EnsembleScore {
  double q_mse = 0;  ///< of the mean of its members [rad^2]
  /// Share of samples and joints inside the 90 % band, mean +- t sqrt(1 + 1/k) s of k members with
  /// standard deviation s, t the Student quantile of k - 1 degrees of freedom. Errors that all
  /// members share, from their data or structure, are not in the band.
  double coverage = 0;
};

inline constexpr int kFewestMembers = 3;

/// @param members  rollouts of the same start, at least kFewestMembers; NaN beyond their length
EnsembleScore ensemble_score(std::span<const Rollout* const> members, const Trajectory& trajectory,
                             int steps);

}  // namespace fricid::evaluate
