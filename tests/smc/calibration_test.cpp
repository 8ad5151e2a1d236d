// B: particle Gibbs with conjugate draws of Q and R is calibrated (Talts et al. 2018): the true
// parameter's rank among posterior draws is uniform when truth and data come from the model.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "fricid/smc/particle_gibbs.hpp"
#include "friction_toy.hpp"

namespace fricid::smc {
namespace {

constexpr int kDraws = 63, kQuantities = 5;
constexpr int kTrialSteps = 25, kTrialParticles = 15, kBurnIn = 20, kThin = 3;
constexpr double kShape = 6;  // of the inverse gamma priors of the variances

/// Gamma(shape >= 1, 1) by Marsaglia & Tsang (2000).
double gamma_draw(Rng& rng, double shape) {
  const double d = shape - 1.0 / 3, c = 1 / std::sqrt(9 * d);
  for (;;) {
    const double x = rng.normal(), v = std::pow(1 + c * x, 3);
    if (v > 0 && std::log(rng.uniform()) < 0.5 * x * x + d - d * v + d * std::log(v)) return d * v;
  }
}

/// A variance given `count` residuals with this sum of squares; prior mean `typical`.
double variance_draw(Rng& rng, double typical, double squares = 0, int count = 0) {
  return ((kShape - 1) * typical + 0.5 * squares) / gamma_draw(rng, kShape + 0.5 * count);
}

struct Typical {
  double q = 1e-8, v = 4e-4, z = 1e-8, y = 4e-8;
};

test::FrictionToy toy_with(double q, double v, double z, double y) {
  test::FrictionToy toy(1);
  toy.dt = 0.02;
  toy.amplitude = 1.5;
  toy.start.covariance.diagonal() << 1e-7, 1e-2, 1e-6;
  toy.noise.diagonal() << q, v, z;
  toy.error(0, 0) = y;
  return toy;
}

/// Q and R given a path.
test::FrictionToy draw_noise(const test::FrictionToy& toy, const RowMatrix& x, const RowMatrix& y,
                             Rng& rng) {
  double squares[4] = {};
  for (int t = 0; t < kTrialSteps; ++t) {
    squares[3] += std::pow(y(t, 0) - x(t, 0), 2);
    if (t + 1 == kTrialSteps) break;
    std::array<double, 3> f = {x(t, 0), x(t, 1), x(t, 2)};
    toy.transition(t, std::span<double>(f));
    for (int i = 0; i < 3; ++i) {
      squares[i] += std::pow(x(t + 1, i) - f[static_cast<std::size_t>(i)], 2);
    }
  }
  const Typical typical;
  const double q = variance_draw(rng, typical.q, squares[0], kTrialSteps - 1);
  const double v = variance_draw(rng, typical.v, squares[1], kTrialSteps - 1);
  const double z = variance_draw(rng, typical.z, squares[2], kTrialSteps - 1);
  return toy_with(q, v, z, variance_draw(rng, typical.y, squares[3], kTrialSteps));
}

/// What is ranked: three variances, the velocity in the middle and the bristle at the end.
std::array<double, kQuantities> quantities(const test::FrictionToy& toy, const RowMatrix& x) {
  return {toy.noise(1, 1), toy.noise(2, 2), toy.error(0, 0), x(kTrialSteps / 2, 1),
          x(kTrialSteps - 1, 2)};
}

/// Ranks of the truth among kDraws posterior draws.
std::array<int, kQuantities> ranks(std::uint64_t replication) {
  Rng rng(11, replication);
  const Typical typical;
  test::FrictionToy toy = toy_with(variance_draw(rng, typical.q), variance_draw(rng, typical.v),
                                   variance_draw(rng, typical.z), variance_draw(rng, typical.y));
  auto [path, y] = test::simulate_toy(toy, kTrialSteps, replication);
  const auto truth = quantities(toy, path);

  // from the truth, which is a draw of the posterior: burn-in only has to forget it
  std::array<int, kQuantities> rank{};
  FilterOptions options;
  options.particles = kTrialParticles;
  options.seed = 100 + replication;
  for (std::uint32_t sweep = 0; sweep < kBurnIn + kThin * kDraws; ++sweep) {
    AdaptedGuide<PackD> guide(toy, y);
    ParticleGibbs gibbs(toy, guide, options);
    EXPECT_TRUE(gibbs.sweep(path, sweep));
    toy = draw_noise(toy, path, y, rng);
    if (sweep < kBurnIn || (sweep - kBurnIn) % kThin != kThin - 1) continue;
    const auto drawn = quantities(toy, path);
    for (std::size_t k = 0; k < kQuantities; ++k) rank[k] += drawn[k] < truth[k] ? 1 : 0;
  }
  return rank;
}

TEST(Calibration, RanksOfTheTruthAreUniform) {
  constexpr int kReplications = 1000, kBins = 16, kRanks = kDraws + 1;
  std::array<std::array<int, kRanks>, kQuantities> histogram{};
  for (int r = 0; r < kReplications; ++r) {
    const auto rank = ranks(static_cast<std::uint64_t>(r));
    for (std::size_t k = 0; k < kQuantities; ++k) {
      ++histogram[k][static_cast<std::size_t>(rank[k])];
    }
  }
  for (std::size_t k = 0; k < kQuantities; ++k) {
    SCOPED_TRACE(k);
    double chi2 = 0, largest_gap = 0;
    int below = 0, covered = 0;
    for (int bin = 0; bin < kBins; ++bin) {
      int count = 0;
      for (int i = 0; i < kRanks / kBins; ++i) {
        count += histogram[k][static_cast<std::size_t>(bin * kRanks / kBins + i)];
      }
      constexpr double kExpected = double(kReplications) / kBins;
      chi2 += (count - kExpected) * (count - kExpected) / kExpected;
    }
    for (int i = 0; i < kRanks; ++i) {
      below += histogram[k][static_cast<std::size_t>(i)];
      largest_gap =
          std::max(largest_gap, std::abs(double(below) / kReplications - double(i + 1) / kRanks));
      // 58 of 64 ranks, 90.6 %
      if (i >= 3 && i < kRanks - 3) covered += histogram[k][static_cast<std::size_t>(i)];
    }
    EXPECT_LT(chi2, 37.7) << "15 degrees of freedom, p = 1e-3";
    EXPECT_LT(largest_gap, 1.63 / std::sqrt(kReplications)) << "Kolmogorov's 99 % band";
    EXPECT_GT(covered, 0.875 * kReplications);
    EXPECT_LT(covered, 0.935 * kReplications);
  }
}

}  // namespace
}  // namespace fricid::smc
