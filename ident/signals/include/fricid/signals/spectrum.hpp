// Power spectrum of a sampled signal.
#pragma once

#include <Eigen/Core>

namespace fricid::signals {

/// One-sided density at frequency_hz.
struct Spectrum {
  Eigen::VectorXd frequency_hz;
  Eigen::VectorXd density;  ///< [unit^2 / Hz]
};

/// Welch's method (IEEE Trans. Audio 15(2), 1967): Hann windows of `segment` samples that overlap
/// by half, the mean of each taken off, periodograms averaged; without the bin at 0. Its integral
/// over frequency is the variance. Missing values count as 0.
/// @param segment  even; shortened to a signal that has fewer samples
Spectrum welch(const Eigen::VectorXd& x, double rate_hz, int segment);

/// Bins averaged over a sixth of an octave, as a logarithmic axis shows them.
Spectrum smoothed_by_octaves(const Spectrum& fine);

}  // namespace fricid::signals
