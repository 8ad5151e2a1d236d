// Random streams: published words, distribution, independence, order of drawing.
#include "fricid/base/rng.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <numbers>
#include <numeric>
#include <string>
#include <vector>

#include "fricid/base/single_normals.hpp"

namespace fricid {
namespace {

using PhiloxWords = std::array<std::uint32_t, 4>;
using ::testing::ElementsAre;

constexpr int kDraws = 1'000'000;
constexpr double kLimit = 4.5;  // standard errors, p = 7e-6
constexpr std::uint64_t kSeed = 20240613;

/// Random123's kat_vectors for philox4x32 10 and 7.
TEST(Philox, KnownAnswers) {
  const std::uint32_t ones = 0xFFFFFFFF;
  EXPECT_EQ(philox4x32({0, 0, 0, 0}, {0, 0}),
            (PhiloxWords{0x6627E8D5, 0xE169C58D, 0xBC57AC4C, 0x9B00DBD8}));
  EXPECT_EQ(philox4x32({ones, ones, ones, ones}, {ones, ones}),
            (PhiloxWords{0x408F276D, 0x41C83B0E, 0xA20BC7C6, 0x6D5451FD}));
  EXPECT_EQ(philox4x32({0x243F6A88, 0x85A308D3, 0x13198A2E, 0x03707344}, {0xA4093822, 0x299F31D0}),
            (PhiloxWords{0xD16CFE09, 0x94FDCCEB, 0x5001E420, 0x24126EA1}));
  EXPECT_EQ(philox4x32({0, 0, 0, 0}, {0, 0}, 7),
            (PhiloxWords{0x5F6FB709, 0x0D893F64, 0x4F121F81, 0x4F730A48}));
  EXPECT_EQ(philox4x32({ones, ones, ones, ones}, {ones, ones}, 7),
            (PhiloxWords{0x5207DDC2, 0x45165E59, 0x4D8EE751, 0x8C52F662}));
}

/// The draws of one stream, computed from Philox with 40 digits.
TEST(Rng, DrawsAgreeWithExactArithmetic) {
  const std::uint64_t seed = 0x123456789ABCDEF0, stream = 0x0FEDCBA987654321;
  struct Case {
    std::uint64_t first;
    double uniform[4], normal[4];
  };
  const Case cases[] = {
      {0,
       {0x1.67bfa06aed80cp-3, 0x1.838de3e52f2a9p-1, 0x1.741888ead30e3p-1, 0x1.8cd740b14b84ap-2},
       {0.21314855684594092, -0.2130852134562327, -0.6253064680080621, -1.0615110435211565}},
      {4000000028,
       {0x1.9abd3fd94b491p-1, 0x1.7e172c9f935c4p-3, 0x1.a760d2b58c957p-1, 0x1.3166783f3eee3p-1},
       {0.5998095057743111, 0.539221091016727, -1.5479216060573735, -0.7862585337822915}}};
  for (const Case& c : cases) {
    Rng uniform(seed, stream, c.first), normal(seed, stream, c.first);
    for (int i = 0; i < 4; ++i) {
      EXPECT_EQ(uniform.uniform(), c.uniform[i]);
      EXPECT_NEAR(normal.normal(), c.normal[i], 1e-15);
    }
    EXPECT_EQ(normal.draw(), c.first + 4);
  }
}

/// Draw k in bulk is draw k one by one, wherever the bulk starts and ends.
TEST(Rng, BulkEqualsOneByOneToTheBit) {
  const std::uint64_t stream = 5;
  Rng uniform(kSeed, stream), normal(kSeed, stream);
  std::vector<double> u(101), n(101);
  for (double& x : u) x = uniform.uniform();
  for (double& x : n) x = normal.normal();
  for (std::size_t first = 0; first < 20; ++first) {
    for (std::size_t count = 0; count + first <= u.size(); ++count) {
      std::vector<double> out(count + 1, -99.0);
      const std::span<double> part(out.data(), count);
      fill_uniform(kSeed, stream, first, part);
      ASSERT_EQ(std::memcmp(out.data(), u.data() + first, count * sizeof(double)), 0)
          << first << " " << count;
      fill_normal(kSeed, stream, first, part);
      ASSERT_EQ(std::memcmp(out.data(), n.data() + first, count * sizeof(double)), 0)
          << first << " " << count;
      ASSERT_EQ(out.back(), -99.0);
    }
  }
}

TEST(Rng, SkippingAheadIsDrawing) {
  Rng drawn(kSeed, 1);
  for (int i = 0; i < 1001; ++i) drawn.normal();
  Rng skipped(kSeed, 1, 1001);
  for (int i = 0; i < 10; ++i) EXPECT_EQ(drawn.normal(), skipped.normal());
}

TEST(Rng, SeedStreamAndKindAllMatter) {
  const auto first = [](std::uint64_t seed, std::uint64_t stream) {
    return Rng(seed, stream).uniform();
  };
  const double x = first(1, 1);
  const std::uint64_t high = std::uint64_t{1} << 32;  // the upper words count too
  EXPECT_NE(x, first(2, 1));
  EXPECT_NE(x, first(1, 2));
  EXPECT_NE(x, first(1 + high, 1));
  EXPECT_NE(x, first(1, 1 + high));
  EXPECT_NE(Rng(1, 1, 2 * high).uniform(), x);
}

std::vector<double> uniforms(std::uint64_t stream, std::uint64_t seed = kSeed) {
  std::vector<double> x(kDraws);
  fill_uniform(seed, stream, 0, x);
  return x;
}
std::vector<double> normals(std::uint64_t stream, std::uint64_t seed = kSeed) {
  std::vector<double> x(kDraws);
  fill_normal(seed, stream, 0, x);
  return x;
}

/// (mean of f - expected) in standard errors, the variance of f being known.
template <class Function>
double mean_z(const std::vector<double>& x, Function f, double expected, double variance) {
  double sum = 0;
  for (const double value : x) sum += f(value);
  const double n = static_cast<double>(x.size());
  return (sum / n - expected) / std::sqrt(variance / n);
}

/// Chi-square of `bins` equally likely bins, in standard errors; `share` maps to (0, 1).
template <class Function>
double chi_square_z(const std::vector<double>& x, int bins, Function share) {
  std::vector<int> count(static_cast<std::size_t>(bins));
  for (const double value : x) ++count.at(static_cast<std::size_t>(share(value) * bins));
  const double expected = static_cast<double>(x.size()) / bins;
  double chi2 = 0;
  for (const int c : count) chi2 += (c - expected) * (c - expected) / expected;
  return (chi2 - (bins - 1)) / std::sqrt(2.0 * (bins - 1));
}

/// sqrt(n) sup |F_n - F|; above 2.3 with p = 5e-5.
template <class Function>
double kolmogorov(std::vector<double> x, Function cdf) {
  std::sort(x.begin(), x.end());
  const double n = static_cast<double>(x.size());
  double distance = 0;
  for (std::size_t i = 0; i < x.size(); ++i) {
    const double F = cdf(x[i]), k = static_cast<double>(i);
    distance = std::max({distance, F - k / n, (k + 1) / n - F});
  }
  return std::sqrt(n) * distance;
}

double identity(double x) { return x; }
double normal_cdf(double x) { return 0.5 * std::erfc(-x / std::sqrt(2.0)); }

TEST(Rng, UniformsAreUniform) {
  const std::vector<double> x = uniforms(1);
  const auto [low, high] = std::minmax_element(x.begin(), x.end());
  EXPECT_GT(*low, 0);
  EXPECT_LT(*high, 1);
  EXPECT_LT(std::fabs(mean_z(x, identity, 0.5, 1.0 / 12)), kLimit);
  EXPECT_LT(std::fabs(mean_z(
                x, [](double u) { return u * u; }, 1.0 / 3, 4.0 / 45)),
            kLimit);
  EXPECT_LT(std::fabs(chi_square_z(x, 1000, identity)), kLimit);
  EXPECT_LT(kolmogorov(x, identity), 2.3);
}

/// Moments of N(0, 1): 0, 1, 0, 3 with variances 1, 2, 15, 96; its distribution and its tails.
void expect_normal(const std::vector<double>& x) {
  EXPECT_LT(std::fabs(mean_z(x, identity, 0, 1)), kLimit);
  EXPECT_LT(std::fabs(mean_z(
                x, [](double v) { return v * v; }, 1, 2)),
            kLimit);
  EXPECT_LT(std::fabs(mean_z(
                x, [](double v) { return v * v * v; }, 0, 15)),
            kLimit);
  EXPECT_LT(std::fabs(mean_z(
                x, [](double v) { return v * v * v * v; }, 3, 96)),
            kLimit);
  EXPECT_LT(std::fabs(chi_square_z(x, 1000, normal_cdf)), kLimit);
  EXPECT_LT(kolmogorov(x, normal_cdf), 2.3);
  // beyond 4 standard deviations
  const double tail = 2 * normal_cdf(-4);
  EXPECT_LT(std::fabs(mean_z(
                x, [](double v) { return std::fabs(v) > 4 ? 1.0 : 0.0; }, tail, tail)),
            kLimit);
}

TEST(Rng, NormalsAreNormal) { expect_normal(normals(1)); }

TEST(SingleNormals, AreNormalAndUncorrelated) {
  std::vector<float> out(kDraws);
  fill_normal(kSeed, 1, out);
  const std::vector<double> x(out.begin(), out.end());
  expect_normal(x);
  for (const std::size_t lag : {1u, 2u, 3u, 4u, 8u, 16u, 17u, 32u, 64u}) {
    double sum = 0, squares = 0;
    for (std::size_t i = 0; i + lag < x.size(); ++i) {
      sum += x[i] * x[i + lag];
      squares += (x[i] * x[i] - 1) * (x[i + lag] * x[i + lag] - 1) / 2;
    }
    const double root = std::sqrt(static_cast<double>(x.size() - lag));
    EXPECT_LT(std::fabs(sum / root), kLimit) << lag;
    EXPECT_LT(std::fabs(squares / root), kLimit) << lag;
  }
}

// A draw is that of Philox's words through Box and Muller in double precision, and does not depend
// on how many are asked for.
TEST(SingleNormals, FollowTheWordsOfPhilox) {
  constexpr std::uint64_t kStream = 0x300000002;
  std::vector<float> all(200);
  fill_normal(kSeed, kStream, all);
  for (std::uint32_t block = 0; block < 50; ++block) {
    const auto w = philox4x32({block, 0x40000000, 2, 3}, {kSeed & 0xFFFFFFFF, kSeed >> 32}, 7);
    for (std::size_t pair = 0; pair < 2; ++pair) {
      const double u = (w[2 * pair] + 0.5) * 0x1p-32, a = (w[2 * pair + 1] + 0.5) * 0x1p-32;
      const double r = std::sqrt(-2 * std::log(u)), angle = 2 * std::numbers::pi * a;
      const float* x = all.data() + 4 * block + 2 * pair;
      EXPECT_NEAR(x[0], r * std::cos(angle), 4e-6);
      EXPECT_NEAR(x[1], r * std::sin(angle), 4e-6);
    }
  }
  for (std::size_t count = 0; count < 70; ++count) {
    std::vector<float> some(count + 1, -99.0F);
    fill_normal(kSeed, kStream, std::span(some).first(count));
    ASSERT_TRUE(std::equal(some.begin(), some.end() - 1, all.begin())) << count;
    ASSERT_EQ(some.back(), -99.0F);
  }
}

/// sqrt(n) times the correlation of x[i] and y[i + lag], both of mean 0 and variance 1.
double correlation_z(const std::vector<double>& x, const std::vector<double>& y, std::size_t lag) {
  double sum = 0;
  for (std::size_t i = 0; i + lag < x.size(); ++i) sum += x[i] * y[i + lag];
  return sum / std::sqrt(static_cast<double>(x.size() - lag));
}

TEST(Rng, DrawsOfAStreamAreUncorrelated) {
  const std::vector<double> x = normals(1);
  std::vector<double> square(x);
  for (double& v : square)
    v = (v * v - 1) / std::sqrt(2.0);  // also for dependence without correlation
  for (const std::size_t lag : {1, 2, 3, 4, 8, 16, 17, 64}) {
    EXPECT_LT(std::fabs(correlation_z(x, x, lag)), kLimit) << lag;
    EXPECT_LT(std::fabs(correlation_z(square, square, lag)), kLimit) << lag;
  }
}

TEST(Rng, StreamsSeedsAndKindsAreIndependent) {
  const std::vector<double> x = normals(1);
  std::vector<double> u = uniforms(1);
  for (double& v : u) v = (v - 0.5) * std::sqrt(12.0);
  const std::vector<double> others[] = {
      normals(0), normals(2), normals(3), normals(std::uint64_t{1} << 32), normals(1, kSeed + 1),
      u};
  for (const auto& other : others) {
    for (const std::size_t lag : {0, 1, 2}) {
      EXPECT_LT(std::fabs(correlation_z(x, other, lag)), kLimit) << lag;
      EXPECT_LT(std::fabs(correlation_z(other, x, lag)), kLimit) << lag;
    }
  }
}

/// Pairs of a block: angle and radius. 32 x 32 cells of (draw 2 k, draw 2 k + 1).
TEST(Rng, NeighboursFillThePlane) {
  const std::vector<double> x = normals(7);
  std::vector<double> cell;
  for (std::size_t i = 0; i + 1 < x.size(); i += 2) {
    const double a = std::floor(normal_cdf(x[i]) * 32), b = std::floor(normal_cdf(x[i + 1]) * 32);
    cell.push_back((a * 32 + b + 0.5) / 1024);
  }
  EXPECT_LT(std::fabs(chi_square_z(cell, 1024, identity)), kLimit);
}

}  // namespace
}  // namespace fricid
