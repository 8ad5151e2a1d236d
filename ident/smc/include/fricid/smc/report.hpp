// Health figures of a filter and a smoother.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

namespace fricid::smc {

/// A health figure out of its range: what it means and what to do about it.
struct Warning {
  std::string figure;   ///< e.g. "distinct roots 3 of 200"
  std::string meaning;  ///< what it says about the result
  std::string remedy;   ///< what usually helps
};

/// Mean normalised innovation squared per present channel against 1, as it is when the noise is as
/// large as the model says.
struct NisFigure {
  double mean = 1;
  double half_width = 0;  ///< 3 sigma of the mean for a true model; infinite without observations
  /// The warning when the mean is out of its range; else none.
  std::optional<Warning> warning() const;
};
/// @param nis      (T) normalised innovation squared
/// @param present  (T) its degrees of freedom
NisFigure nis_figure(std::span<const double> nis, std::span<const int> present);

/// Result of one run over T observations. Numerical trouble is a field, never an exception; the
/// figures up to `steps` are valid then. docs/inference.md explains each figure.
struct Report {
  bool failed = true;         ///< all weights vanished, or one was NaN, at step `steps`
  int steps = 0;              ///< observations taken in
  int particles = 0;          ///< N
  double log_likelihood = 0;  ///< estimate of log p(y) [nat]; -inf when failed

  std::vector<double> ess;  ///< (T) effective sample size of the weights at t, in [1, N]
  int resampled = 0;        ///< steps at which particles were resampled
  int distinct_roots = 0;   ///< particles at t = 0 that have descendants at t = T - 1

  std::vector<double> nis;   ///< (T) normalised innovation squared of the filter, or empty
  std::vector<int> present;  ///< (T) its degrees of freedom: channels observed at t, or empty

  // filled by the backward smoothers, else empty or 0
  std::vector<double> backward_ess;  ///< (T - 1) mean over paths of the ESS of the backward weights
  int paths = 0;                     ///< smoothed paths M
  int path_roots = 0;                ///< different particles at t = 0 among them
  /// Share of (path, t) whose ancestor is not the one of the filter; 1 for traced paths, which have
  /// no other.
  double refreshed = 0;

  /// Empties it for a run of T steps and N particles; allocates only when T grows.
  void reset(int T, int N);

  double min_ess() const;
  double median_ess() const;
  double median_backward_ess() const;
  double nis_per_channel() const { return nis_figure(nis, present).mean; }

  /// A warning for every figure out of its range, the most important first.
  std::vector<Warning> warnings() const;
};

}  // namespace fricid::smc
