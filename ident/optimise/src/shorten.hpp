// Shortening of unusually long gradients.
#pragma once

namespace fricid::optimise {

/// Share of a gradient that a step takes: one longer than three times the running mean of their
/// length counts as that long.
/// @param step         1 for the first gradient
/// @param mean_length  running mean, brought up to date
double shorten_gradient(double length, int step, double& mean_length);

}  // namespace fricid::optimise
