// What the trainings by gradients share.
#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "fricid/base/rng.hpp"
#include "fricid/estimate/windows/multi_step.hpp"

namespace fricid::estimate {

/// Step length over the course of a training, relative to the first.
double training_schedule(int iteration, int iterations);

/// Windows of `steps` samples drawn uniformly from the training part, but for a share that begins
/// where a recording does: a rollout starts at rest, where little of a recording is.
std::vector<Window> draw_windows(std::span<const Recording> recordings, const Split& split,
                                 int steps, int count, double from_rest, Rng& rng);

/// Share of a gradient that a step takes: one longer than three times the running mean of their
/// length counts as that long.
/// @param step         1 for the first gradient
/// @param mean_length  running mean, brought up to date
double shorten_gradient(double length, int step, double& mean_length);

/// (n) diagonal of M^-1 at a row of a recording [1/(kg m^2)]: how easily each joint moves while the
/// others are free.
Eigen::VectorXd mobility(const dynamics::RobotModel& robot, const Recording& recording, int row);

}  // namespace fricid::estimate
