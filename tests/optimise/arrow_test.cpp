// The arrow-structured solve against that of the full matrix.
#include "fricid/optimise/arrow.hpp"

#include <gtest/gtest.h>
#include <Eigen/Cholesky>

namespace fricid::optimise {
namespace {

/// J'J of residuals each of which sees one block and the rest.
Eigen::MatrixXd arrow(Eigen::Index size, const std::vector<Block>& blocks) {
  Eigen::MatrixXd H = Eigen::MatrixXd::Zero(size, size);
  for (const Block& own : blocks) {
    Eigen::MatrixXd J = Eigen::MatrixXd::Random(3 * size, size);
    for (const Block& other : blocks)
      if (other.begin != own.begin) J.middleCols(other.begin, other.size).setZero();
    H += J.transpose() * J;
  }
  return H;
}

TEST(SolveArrow, EqualsTheFullSolve) {
  std::srand(1);
  const std::vector<std::vector<Block>> cases{
      {}, {{0, 4}, {4, 7}, {11, 1}}, {{2, 5}, {9, 3}}, {{0, 10}, {10, 10}}};
  for (const std::vector<Block>& blocks : cases) {
    SCOPED_TRACE(blocks.size());
    Eigen::MatrixXd H = blocks.empty() ? arrow(20, {{0, 20}}) : arrow(20, blocks);
    const Eigen::VectorXd g = Eigen::VectorXd::Random(20);
    const Eigen::VectorXd wanted = H.ldlt().solve(g);
    EXPECT_LT((solve_arrow(H, g, blocks) - wanted).norm(), 1e-10 * wanted.norm());
  }
}

// A coordinate that is held has a unit row: the blocks keep to themselves.
TEST(SolveArrow, SolvesBlocksThatTheRestDoesNotTouch) {
  Eigen::MatrixXd H = Eigen::MatrixXd::Identity(5, 5) * 2;
  H(0, 1) = H(1, 0) = 1;
  const Eigen::VectorXd g = Eigen::VectorXd::LinSpaced(5, 1, 5);
  const Eigen::VectorXd x = solve_arrow(H, g, {{0, 2}, {2, 1}});
  EXPECT_LT((H * x - g).norm(), 1e-14);
}

}  // namespace
}  // namespace fricid::optimise
