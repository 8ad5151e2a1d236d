// Symmetric systems whose matrix is an arrow: blocks that meet only in a common rest.
#pragma once

#include <Eigen/Core>
#include <vector>

namespace fricid::optimise {

/// Coordinates begin .. begin + size - 1.
struct Block {
  Eigen::Index begin, size;
};

/// x with H x = g, H symmetric and positive semidefinite, where the coordinates of one block meet
/// those of another nowhere: with D_b the blocks, R the rest and B_b what couples a block to it,
///
///     (R - sum_b B_b D_b^-1 B_b') x_R = g_R - sum_b B_b D_b^-1 g_b,
///     x_b = D_b^-1 (g_b - B_b' x_R),
///
/// each by LDL'. Entries of H between two blocks are not read. Without blocks the whole of H is
/// the rest.
/// @param blocks  in ascending order, disjoint
Eigen::VectorXd solve_arrow(const Eigen::MatrixXd& H, const Eigen::VectorXd& g,
                            const std::vector<Block>& blocks);

}  // namespace fricid::optimise
