// Block means of a signal.
#pragma once

#include <Eigen/Core>

namespace fricid::signals {

/// Means of the finite values in each of `blocks` equal parts of x, what is left over at its end
/// not counted; NaN where a part has none.
Eigen::VectorXd block_means(const Eigen::VectorXd& x, int blocks);

}  // namespace fricid::signals
