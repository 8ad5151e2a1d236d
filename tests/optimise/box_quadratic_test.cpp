#include "fricid/optimise/box_quadratic.hpp"

#include <gtest/gtest.h>

#include "fricid/base/rng.hpp"

namespace fricid::optimise {
namespace {

struct Problem {
  Eigen::MatrixXd H;
  Eigen::VectorXd g;
  Box box;
};

/// Strongly coupled coordinates, some of which begin on a side of the box.
Problem random_problem(std::uint64_t seed, Eigen::Index size) {
  Rng rng(seed, 0);
  const auto normal = [&] { return rng.normal(); };
  const Eigen::MatrixXd J = Eigen::MatrixXd::NullaryExpr(size + 2, size, normal);
  Problem out{J.transpose() * J, 3 * Eigen::VectorXd::NullaryExpr(size, normal), {}};
  out.box.upper = Eigen::VectorXd::NullaryExpr(size, normal).cwiseMax(0);
  out.box.lower = -Eigen::VectorXd::NullaryExpr(size, normal).cwiseMax(0);
  return out;
}

// Karush, Kuhn and Tucker: inside the slope is zero, at a side it presses against it.
TEST(LeastInBox, HasNoSlopeInsideAndPressesAtTheSides) {
  for (std::uint64_t seed = 1; seed <= 200; ++seed) {
    const Problem of = random_problem(seed, 12);
    const Eigen::VectorXd s = least_in_box(of.H, of.g, {}, of.box), slope = of.g + of.H * s;
    for (Eigen::Index i = 0; i < s.size(); ++i) {
      ASSERT_GE(s[i], of.box.lower[i]);
      ASSERT_LE(s[i], of.box.upper[i]);
      if (s[i] > of.box.lower[i]) {
        EXPECT_LT(slope[i], 1e-7) << seed;
      }
      if (s[i] < of.box.upper[i]) {
        EXPECT_GT(slope[i], -1e-7) << seed;
      }
    }
  }
}

TEST(LeastInBox, IsThatOfAnArrow) {
  const Problem of = random_problem(5, 9);
  const std::vector<Block> blocks{{0, 3}, {3, 4}};
  Eigen::MatrixXd H = of.H;
  H.block(0, 3, 3, 4).setZero();
  H.block(3, 0, 4, 3).setZero();
  H.diagonal().array() += 20;
  EXPECT_LT((least_in_box(H, of.g, blocks, of.box) - least_in_box(H, of.g, {}, of.box)).norm(),
            1e-12);
}

}  // namespace
}  // namespace fricid::optimise
