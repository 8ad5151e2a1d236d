// C: weights and resampling.
#include "fricid/smc/resampling.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <set>
#include <vector>

#include "fricid/base/rng.hpp"

namespace fricid::smc {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr Resampling kSchemes[] = {Resampling::kSystematic, Resampling::kStratified,
                                   Resampling::kMultinomial, Resampling::kKilling};

std::vector<double> random_weights(std::size_t N, std::uint64_t seed) {
  std::vector<double> lw(N), W(N);
  Rng rng(seed, 0);
  for (double& x : lw) x = 2 * rng.normal();
  normalise(lw, W);
  return W;
}

std::vector<int> counts(Resampling scheme, const std::vector<double>& W, std::uint64_t draw) {
  std::vector<double> u(uniforms_needed(scheme, W.size()));
  std::vector<int> ancestors(W.size(), -1), count(W.size(), 0);
  fill_uniform(1, draw, 0, u);
  resample(scheme, W, u, ancestors);
  for (const int a : ancestors) ++count.at(static_cast<std::size_t>(a));
  return count;
}

TEST(Normalise, AgreesWithTheDefinition) {
  for (const std::size_t N : {1u, 2u, 7u, 8u, 9u, 200u}) {
    std::vector<double> lw(N), W(N);
    Rng rng(N, 0);
    double sum = 0, square = 0;
    for (double& x : lw) {
      x = 3 * rng.normal() - 700;
      sum += std::exp(x + 700);
      square += std::exp(2 * (x + 700));
    }
    const auto result = normalise(lw, W);
    ASSERT_TRUE(result);
    EXPECT_NEAR(result->log_sum, std::log(sum) - 700, 1e-11);
    EXPECT_NEAR(result->ess, sum * sum / square, 1e-9);
    for (std::size_t i = 0; i < N; ++i) EXPECT_NEAR(W[i], std::exp(lw[i] + 700) / sum, 1e-14);
  }
}

TEST(Normalise, SurvivesEveryKindOfWeight) {
  const double tiny = std::log(1e-300);
  struct Case {
    std::vector<double> lw;
    double log_sum, ess;
  };
  const Case cases[] = {
      {{-kInfinity, 0, -kInfinity}, 0, 1},
      {{-kInfinity, -1e5, -kInfinity}, -1e5, 1},
      {{tiny, tiny}, tiny + std::log(2), 2},
      {{0, tiny}, 0, 1},
      {{-3.5}, -3.5, 1},
      {{1e5, 1e5, -kInfinity, 1e5}, 1e5 + std::log(3), 3},
  };
  for (const Case& c : cases) {
    std::vector<double> W(c.lw.size());
    const auto result = normalise(c.lw, W);
    ASSERT_TRUE(result);
    EXPECT_NEAR(result->log_sum, c.log_sum, 1e-10);
    EXPECT_NEAR(result->ess, c.ess, 1e-12);
    EXPECT_NEAR(std::accumulate(W.begin(), W.end(), 0.0), 1, 1e-14);
  }
}

TEST(Normalise, WithoutAnyWeightIsAnErrorValue) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const std::vector<std::vector<double>> cases = {
      {-kInfinity}, std::vector<double>(17, -kInfinity), {0, nan}, {nan, 0}, {nan}, {0, kInfinity}};
  for (const auto& lw : cases) {
    std::vector<double> W(lw.size());
    EXPECT_FALSE(normalise(lw, W).has_value());
  }
}

TEST(Resample, SystematicCountsAreWithinOneOfTheirMean) {
  for (const std::size_t N : {1u, 2u, 13u, 200u, 1000u}) {
    for (std::uint64_t seed = 0; seed < 50; ++seed) {
      const auto W = random_weights(N, seed);
      const auto count = counts(Resampling::kSystematic, W, seed);
      for (std::size_t i = 0; i < N; ++i) {
        EXPECT_LT(std::abs(count[i] - static_cast<double>(N) * W[i]), 1);
      }
    }
  }
}

// Claim: E count_i = N W_i and E count_i^2 no larger than multinomial resampling has it.
TEST(Resample, EverySchemeIsUnbiased) {
  constexpr int kDraws = 4000;
  constexpr std::size_t N = 23;
  const auto W = random_weights(N, 5);
  for (const Resampling scheme : kSchemes) {
    SCOPED_TRACE(static_cast<int>(scheme));
    std::vector<double> sum(N, 0), square(N, 0);
    for (int k = 0; k < kDraws; ++k) {
      const auto count = counts(scheme, W, static_cast<std::uint64_t>(k));
      EXPECT_EQ(std::accumulate(count.begin(), count.end(), 0), static_cast<int>(N));
      for (std::size_t i = 0; i < N; ++i) sum[i] += count[i], square[i] += count[i] * count[i];
    }
    for (std::size_t i = 0; i < N; ++i) {
      const double mean = sum[i] / kDraws, variance = square[i] / kDraws - mean * mean;
      const double expected = static_cast<double>(N) * W[i];
      EXPECT_LT(std::abs(mean - expected), 4.5 * std::sqrt(variance / kDraws) + 1e-3);
      EXPECT_LT(variance, 1.15 * expected * (1 - W[i]) + 0.01);
    }
  }
}

TEST(Resample, WeightlessParticlesNeverSurvive) {
  for (const Resampling scheme : kSchemes) {
    SCOPED_TRACE(static_cast<int>(scheme));
    for (std::uint64_t draw = 0; draw < 200; ++draw) {
      EXPECT_EQ(counts(scheme, {0, 0, 1, 0}, draw), (std::vector<int>{0, 0, 4, 0}));
      EXPECT_EQ(counts(scheme, {1}, draw), std::vector<int>{1});
      const auto count = counts(scheme, {0, 0.5, 0, 0.5 - 1e-16, 0}, draw);
      EXPECT_EQ(count[0] + count[2] + count[4], 0);
      EXPECT_EQ(counts(scheme, {1 - 1e-300, 1e-300}, draw), (std::vector<int>{2, 0}));
    }
  }
}

TEST(Resample, EqualWeightsAreKeptByKilling) {
  EXPECT_EQ(counts(Resampling::kKilling, {0.25, 0.25, 0.25, 0.25}, 3),
            (std::vector<int>{1, 1, 1, 1}));
}

// Claim: the heavy are split exactly, of the light one is drawn by weight; to renew ten per cent
// costs as much of the histories and repairs an outlier.
TEST(SplitHeaviest, IsUnbiasedAndKeepsMostParticles) {
  constexpr std::size_t kCount = 50;
  constexpr int kRenewed = 5, kDraws = 1000;
  std::vector<double> lw(kCount), W(kCount), weights(kCount), mean(kCount, 0.0);
  Rng rng(1, 0);
  for (double& x : lw) x = rng.normal();
  lw[17] = 5;
  lw[3] = -kInfinity;
  const double ess = normalise(lw, W)->ess;
  std::vector<int> ancestors(kCount), copies(kCount);
  for (int k = 0; k < kDraws; ++k) {
    split_heaviest(W, kRenewed, (k + 0.5) / kDraws, ancestors, weights, copies);
    EXPECT_TRUE(std::is_sorted(ancestors.begin(), ancestors.end()));
    EXPECT_EQ(std::set<int>(ancestors.begin(), ancestors.end()).size(), kCount - kRenewed);
    double sum = 0, squares = 0;
    for (std::size_t i = 0; i < kCount; ++i) {
      mean[static_cast<std::size_t>(ancestors[i])] += weights[i] / kDraws;
      sum += weights[i];
      squares += weights[i] * weights[i];
    }
    EXPECT_NEAR(sum, 1, 1e-12);
    EXPECT_GT(1 / squares, 2 * ess);
  }
  for (std::size_t i = 0; i < kCount; ++i) EXPECT_NEAR(mean[i], W[i], 1e-5) << i;
}

TEST(Pick, DrawsInProportion) {
  const std::vector<double> W = {0, 0.2, 0, 0.8, 0};
  EXPECT_EQ(pick(W, 1e-17), 1);
  EXPECT_EQ(pick(W, 0.1999), 1);
  EXPECT_EQ(pick(W, 0.2001), 3);
  EXPECT_EQ(pick(W, 1 - 1e-17), 3);
}

}  // namespace
}  // namespace fricid::smc
