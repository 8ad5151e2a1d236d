// Shared by the methods of gradient training.
#pragma once

#include <Eigen/Core>
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

}  // namespace fricid::estimate
