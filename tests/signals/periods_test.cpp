#include "fricid/signals/periods.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <vector>

#include "fricid/base/rng.hpp"

namespace fricid::signals {
namespace {

constexpr double kSampleRate = 250;

/// Two joints, each the sum of sines of the given frequencies [Hz] and of noise of 0.2 mrad.
RowMatrix swing(const std::vector<double>& frequencies, double seconds, std::uint64_t seed = 1) {
  Rng rng(seed, 0);
  RowMatrix q(static_cast<Eigen::Index>(seconds * kSampleRate), 2);
  for (Eigen::Index k = 0; k < q.rows(); ++k)
    for (Eigen::Index j = 0; j < 2; ++j) {
      q(k, j) = 2e-4 * rng.normal();
      for (std::size_t i = 0; i < frequencies.size(); ++i) {
        const double phase = static_cast<double>(j + 1) * (1 + static_cast<double>(i));
        q(k, j) += 0.3 * std::sin(2 * std::numbers::pi * frequencies[i] * static_cast<double>(k) /
                                      kSampleRate +
                                  phase);
      }
    }
  return q;
}

std::vector<double> harmonics_of(double period) {
  std::vector<double> frequencies;
  for (int k = 1; k <= 8; ++k) frequencies.push_back(k / period);
  return frequencies;
}

TEST(PeriodOf, MotionThatRepeats) {
  for (const double period : {5.0, 7.33, 14.2857})
    EXPECT_NEAR(period_of(swing(harmonics_of(period), 45), 1 / kSampleRate), period * kSampleRate,
                1)
        << period;
}

TEST(PeriodOf, StandingBetweenDoesNotCount) {
  RowMatrix q = swing(harmonics_of(6), 36);
  for (Eigen::Index k = 0; k < q.rows(); ++k)  // four seconds of each six
    if (k % 1500 > 500) q.row(k) = q.row(k - k % 1500 + 500);
  EXPECT_NEAR(period_of(q, 1 / kSampleRate), 1500, 1);
}

TEST(PeriodOf, NoneOfMotionThatDoesNot) {
  EXPECT_EQ(period_of(swing({0.1, 0.1 * std::numbers::sqrt2, 0.3 * std::numbers::e, 0.77}, 60),
                      1 / kSampleRate),
            0);
  EXPECT_EQ(period_of(swing(harmonics_of(40), 45), 1 / kSampleRate), 0);  // little more than one
  EXPECT_EQ(period_of(RowMatrix::Constant(9000, 2, 0.5), 1 / kSampleRate), 0);
  EXPECT_EQ(period_of(RowMatrix::Zero(2, 2), 1 / kSampleRate), 0);
}

TEST(SameMotion, IsToldFromAnother) {
  const RowMatrix a = swing(harmonics_of(12), 12), b = swing(harmonics_of(12), 12, 2);
  EXPECT_TRUE(is_same_motion(a, b));
  EXPECT_TRUE(is_same_motion(a, b.topRows(b.rows() - 20)));
  EXPECT_FALSE(is_same_motion(a, b.topRows(b.rows() / 2)));
  EXPECT_FALSE(is_same_motion(a, swing(harmonics_of(11), 12)));
  EXPECT_FALSE(is_same_motion(a, b.leftCols(1)));
}

}  // namespace
}  // namespace fricid::signals
