// The least point of a quadratic in a box.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "fricid/optimise/arrow.hpp"
#include "fricid/optimise/box.hpp"

namespace fricid::optimise {

/// The s that minimises g's + s'H s / 2 with lower <= s <= upper, for H symmetric and positive
/// definite: coordinates that would leave the box stay on its side, and the others are where that
/// is best. An active-set method that exchanges all coordinates at once (Hintermüller, Ito,
/// Kunisch, SIAM J. Optim. 13(3), 2002); where the sets have not settled after some exchanges,
/// coordinates are only added, and s is feasible and near the least point.
/// @param box     holds s = 0
/// @param blocks  of H, see `solve_arrow`; H is zero between two of them
Eigen::VectorXd least_in_box(const Eigen::MatrixXd& H, const Eigen::VectorXd& g,
                             const std::vector<Block>& blocks, const Box& box);

}  // namespace fricid::optimise
