// Shared by the methods of gradient training.
#pragma once

#include <Eigen/Core>
#include <functional>
#include <span>
#include <vector>

#include "fricid/base/rng.hpp"
#include "fricid/estimate/coordinates.hpp"
#include "fricid/estimate/windows/multi_step.hpp"

namespace fricid::estimate {

/// Windows of `steps` samples drawn uniformly from the training part, but for a share that begins
/// where a recording does: a rollout starts at rest, where little of a recording is.
std::vector<Window> draw_windows(std::span<const signals::Recording> recordings, const Split& split,
                                 int steps, int count, double from_rest, Rng& rng);

/// (n, n) M^-1 at a row of a recording [1/(kg m^2)]; its diagonal: how easily each joint moves
/// while the others are free.
Eigen::MatrixXd mobility(const dynamics::RobotModel& robot, const signals::Recording& recording,
                         int row);

/// The steps of training with the longest leap whose gradient is within 20 % of that at the steps
/// of the judge: stiff friction makes long leaps chatter, and gradients through chatter explode.
StepOptions longest_leap(const MultiStepOptions& options,
                         const std::function<Eigen::VectorXd(StepOptions)>& gradient);

/// What training on windows is set up with.
struct WindowSetup {
  int steps;                      ///< samples of a window
  Split split;                    ///< of the recordings
  CoordinateOptions coordinates;  ///< springs no stiffer than the steps of the judge resolve
};

/// @throws UserError when the training part of a recording is shorter than two windows
WindowSetup set_up_windows(const Arm& start, std::span<const signals::Recording> recordings,
                           const MultiStepOptions& options);

}  // namespace fricid::estimate
