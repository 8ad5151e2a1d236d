#include "fricid/signals/decimated_low_pass.hpp"

#include <cmath>

#include <gtest/gtest.h>

#include "fricid/base/rng.hpp"

namespace fricid::signals {
namespace {

using Sums = DecimatedLowPass::Sums<double>;

std::vector<double> noise(int size) {
  std::vector<double> x;
  Rng rng(7, 0);
  for (int k = 0; k < size; ++k) x.push_back(3 + rng.normal());
  return x;
}

/// Sums of the blocks that hold samples [begin, end) of x.
std::vector<Sums> sums_of(const DecimatedLowPass& filter, const std::vector<double>& x, int begin,
                          int end) {
  const int D = filter.every();
  std::vector<Sums> sums(static_cast<std::size_t>((end - 1) / D - begin / D + 1), Sums{});
  for (int k = begin; k < end; ++k) {
    Sums& block = sums[static_cast<std::size_t>(k / D - begin / D)];
    const double value = x[static_cast<std::size_t>(k)];
    for (std::size_t i = 0; i < DecimatedLowPass::kWeighted; ++i)
      block[i] += filter.weights(k % D)[i] * value;
    if (k % D == 0) block.back() = value;
  }
  return sums;
}

// Reference: the filter itself, run over every sample.
TEST(DecimatedLowPass, IsTheFilterAtEveryDthSample) {
  for (const double rate : {200.0, 250.0, 1000.0, 4000.0})
    for (const auto& [begin, cut] : {std::pair{0, 0}, {7, 5}, {240, 241}}) {
      const ZeroPhaseButterworth low_pass(10, rate);
      const DecimatedLowPass decimated(low_pass, decimation(1 / rate, 10));
      const std::vector<double> x = noise(3 * low_pass.padding() + 500);
      const int end = static_cast<int>(x.size()) - cut, D = decimated.every();
      ASSERT_TRUE(decimated.is_of_use(end - begin));

      std::vector<double> all(x.begin() + begin, x.begin() + end), work;
      low_pass.apply(std::span<double>(all), work);
      const std::vector<Sums> sums = sums_of(decimated, x, begin, end);
      std::vector<double> y(sums.size());
      decimated.apply<double>({begin, end, x[static_cast<std::size_t>(begin)],
                               x[static_cast<std::size_t>(end - 1)], sums},
                              y);
      for (int b = (begin + D - 1) / D; b * D < end; ++b)
        ASSERT_NEAR(y[static_cast<std::size_t>(b - begin / D)],
                    all[static_cast<std::size_t>(b * D - begin)], 1e-11)
            << rate << " Hz, block " << b;
    }
}

TEST(DecimatedLowPass, IsOfNoUseWhereSumsOutnumberSamplesOrTheRecordIsShort) {
  const ZeroPhaseButterworth low_pass(10, 250);
  EXPECT_FALSE(DecimatedLowPass(low_pass, 9).is_of_use(10000));
  EXPECT_FALSE(DecimatedLowPass(low_pass, 12).is_of_use(low_pass.padding()));
  EXPECT_TRUE(DecimatedLowPass(low_pass, 12).is_of_use(low_pass.padding() + 1));
}

}  // namespace
}  // namespace fricid::signals
