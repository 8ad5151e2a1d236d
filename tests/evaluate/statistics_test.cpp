#include "fricid/evaluate/statistics.hpp"
#include "fricid/base/not_finite.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace fricid::evaluate {
namespace {

TEST(Statistics, MeansAndMedianByHand) {
  const std::vector<double> values{1, 100, kNan, 10};
  EXPECT_DOUBLE_EQ(geometric_mean(values), 10);
  EXPECT_DOUBLE_EQ(mean(values), 37);
  EXPECT_DOUBLE_EQ(median(values), 10);
  EXPECT_DOUBLE_EQ(median(std::vector<double>{4, 1, 3, 2}), 2.5);
}

TEST(Statistics, NothingIsNotZero) {
  const std::vector<double> nothing{kNan};
  EXPECT_TRUE(std::isnan(geometric_mean(nothing)));
  EXPECT_TRUE(std::isnan(mean(nothing)));
  EXPECT_TRUE(std::isnan(median(nothing)));
}

TEST(Statistics, OneZeroMakesTheGeometricMeanZero) {
  EXPECT_EQ(geometric_mean(std::vector<double>{0, 1e6}), 0);
}

// Abramowitz & Stegun, table 26.10 (four digits).
TEST(Statistics, StudentQuantilesOfTheTable) {
  EXPECT_NEAR(student_t_quantile(0.95, 1), 6.314, 5e-4);
  EXPECT_NEAR(student_t_quantile(0.95, 2), 2.920, 5e-4);
  EXPECT_NEAR(student_t_quantile(0.95, 3), 2.353, 5e-4);
  EXPECT_NEAR(student_t_quantile(0.95, 4), 2.132, 5e-4);
  EXPECT_NEAR(student_t_quantile(0.95, 10), 1.812, 5e-4);
  EXPECT_NEAR(student_t_quantile(0.975, 5), 2.571, 5e-4);
  EXPECT_NEAR(student_t_quantile(0.05, 30), -1.697, 5e-4);
}

}  // namespace
}  // namespace fricid::evaluate
