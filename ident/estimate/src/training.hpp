// Shared by the methods of gradient training.
#pragma once

#include <Eigen/Core>
#include <functional>
#include <span>
#include <vector>

#include "fricid/base/rng.hpp"
#include "fricid/estimate/windows/multi_step.hpp"

namespace fricid::estimate {

/// Windows of `steps` samples drawn uniformly from the training part, but for a share that begins
/// where a recording does: a rollout starts at rest, where little of a recording is.
std::vector<Window> draw_windows(std::span<const signals::Recording> recordings, const Split& split,
                                 int steps, int count, double from_rest, Rng& rng);

/// (n) diagonal of M^-1 at a row of a recording [1/(kg m^2)]: how easily each joint moves while the
/// others are free.
Eigen::VectorXd mobility(const dynamics::RobotModel& robot, const signals::Recording& recording,
                         int row);

/// (n) stiffness that steps of dt resolve [N m/rad]: sqrt(k/m) dt = 0.5, m = 1/(M^-1)_jj the
/// inertia that joint j shows while the others are free, at the first sample. Gradients through a
/// stiffer spring are those of its chatter.
std::vector<double> resolved_stiffness(const Arm& arm, const signals::Recording& recording,
                                       double dt);

/// The steps of training with the longest leap whose gradient is within 20 % of that at the steps
/// of the judge: stiff friction makes long leaps chatter, and gradients through chatter explode.
StepOptions longest_leap(const MultiStepOptions& options,
                         const std::function<Eigen::VectorXd(StepOptions)>& gradient);

/// @throws UserError when the training part of a recording is shorter than two windows
void require_room_for_windows(std::span<const signals::Recording> recordings, const Split& split,
                              int steps, double window_s);

/// Samples of a window.
int window_steps(std::span<const signals::Recording> recordings, const MultiStepOptions& options);

}  // namespace fricid::estimate
