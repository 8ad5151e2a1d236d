// One open loop of one model along a log.
#pragma once

#include "fricid/data/model_file.hpp"
#include "fricid/evaluate/rollout.hpp"

namespace fricid::evaluate {

/// Rolls a model out under the measured torque of a log, as `evaluate` does without truth: it
/// begins at the filtered position and velocity of a sample, its friction state washed out by the
/// measured motion before.
/// @param cutoff_hz  of the filter
/// @param begin      first sample
/// @param steps      samples to go; they end with the log
/// @throws UserError when the log is too short for that or for the filter, or its joints are not
///         as many as the model's
Rollout roll_out_log(const data::ModelFile& model, const data::Dataset& log, double cutoff_hz,
                     int begin, int steps, const RolloutOptions& options);

}  // namespace fricid::evaluate
