#include "fricid/optimise/nelder_mead.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace fricid::optimise {
namespace {

double valley(const Eigen::VectorXd& c) {
  return std::pow(10 * (c[1] - c[0] * c[0]), 2) + std::pow(1 - c[0], 2);
}

TEST(NelderMead, FindsTheEndOfRosenbrocksValley) {
  const Box box{Eigen::Vector2d(-2, -2), Eigen::Vector2d(2, 2)};
  const Minimum found = nelder_mead(&valley, box, Eigen::Vector2d(-1.2, 1),
                                    {.tolerance = 1e-10, .evaluations = 2000});
  EXPECT_TRUE(found.converged);
  EXPECT_NEAR(found.c[0], 1, 1e-4);
  EXPECT_NEAR(found.c[1], 1, 1e-4);
  EXPECT_EQ(found.value, valley(found.c));
}

// Closed form: on the edge x = 1/2 the valley is least at y = 1/4, with 1/4.
TEST(NelderMead, StaysInItsBoxAndCountsWhatItAsks) {
  const Box box{Eigen::Vector2d(-2, -2), Eigen::Vector2d(0.5, 2)};
  int asked = 0;
  const Minimum found = nelder_mead(
      [&](const Eigen::VectorXd& c) {
        ++asked;
        EXPECT_TRUE(c == box.clamp(c));
        return valley(c);
      },
      box, Eigen::Vector2d(-1.2, 1), {.tolerance = 1e-10, .evaluations = 2000});
  EXPECT_NEAR(found.c[0], 0.5, 1e-6);
  EXPECT_NEAR(found.c[1], 0.25, 1e-4);
  EXPECT_NEAR(found.value, 0.25, 1e-8);
  EXPECT_EQ(found.values, asked);
}

TEST(NelderMead, SaysWhenItRanOut) {
  const Box box{Eigen::Vector2d(-2, -2), Eigen::Vector2d(2, 2)};
  const Minimum found =
      nelder_mead(&valley, box, Eigen::Vector2d(-1.2, 1), {.tolerance = 1e-10, .evaluations = 20});
  EXPECT_FALSE(found.converged);
  EXPECT_EQ(found.values, 20);
}

}  // namespace
}  // namespace fricid::optimise
