// Reversals of a desired motion.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "fricid/signals/matrix.hpp"

namespace fricid::evaluate {

/// Whether each sample of joint j is less than 0.2 s after a change of sign of its velocity.
std::vector<bool> after_reversals(ConstRowMatrix v, Eigen::Index j, double dt);

}  // namespace fricid::evaluate
