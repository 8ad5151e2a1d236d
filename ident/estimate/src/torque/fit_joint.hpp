// Method joint, and what the methods share at their beginning and end.
#pragma once

#include "fricid/estimate/fit.hpp"

namespace fricid::estimate {

/// A report before the fit, with an entry per joint in the lists of scores.
FitReport empty_report(const Prepared& prepared, const ModelOptions& options, int seed);

/// Fits by method joint, see `fit_model`.
FitReport fit_joint(ConventionalFits& conventional, const ModelOptions& options, int seed,
                    int jobs);

/// Residual and explained variance of the training torque under the final arm.
void score_torque(const Prepared& prepared, double cutoff_hz, int jobs, FitReport& report);

}  // namespace fricid::estimate
