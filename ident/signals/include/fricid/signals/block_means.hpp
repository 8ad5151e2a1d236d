// Block means of a signal.
#pragma once

#include <Eigen/Core>

namespace fricid::signals {

/// Means of the finite values in each of `blocks` equal parts of x, without the remainder at its
/// end; NaN for a part without finite values.
Eigen::VectorXd block_means(const Eigen::VectorXd& x, int blocks);

}  // namespace fricid::signals
