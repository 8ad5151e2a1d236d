// A3: the twisted filter is exact on linear models.
#include "fricid/smc/twist.hpp"

#include <gtest/gtest.h>

#include "fricid/smc/particle_filter.hpp"
#include "fricid/smc/statistical_twist.hpp"
#include "linear_gaussian.hpp"

namespace fricid::smc {
namespace {

class TwistOnLinear : public testing::TestWithParam<std::tuple<int, int>> {};

TEST_P(TwistOnLinear, LikelihoodIsExactWithoutVariance) {
  const auto [n, T] = GetParam();
  for (const bool statistical : {false, true})
    for (const bool holes : {false, true}) {
      SCOPED_TRACE(testing::Message() << "holes " << holes << ", statistical " << statistical);
      LinearModel model = test::random_model(n, 3);
      RowMatrix y = test::simulate(model, T, 5).y;
      if (holes) test::punch_holes(y);
      GaussianPath path;
      gaussian_smoother(model, y, path);
      Twist twist;
      if (statistical)
        make_statistical_twist(model, y, path, twist);
      else
        make_twist(model, y, path, twist);

      TwistedGuide<PackD> guide(model, twist);
      Report report;
      for (const std::uint64_t seed : {1, 2, 3}) {
        FilterOptions options;
        options.particles = 20;
        options.seed = seed;
        ParticleFilter filter(model, guide, options);
        filter.run(report);
        EXPECT_NEAR(report.log_likelihood, path.log_likelihood, 1e-8);
        EXPECT_EQ(report.resampled, 0);
        EXPECT_EQ(report.distinct_roots, 20);
        EXPECT_GT(report.min_ess(), 20 - 1e-6);
        for (const double lw : filter.log_weights()) EXPECT_NEAR(lw, -std::log(20), 1e-8);
      }
    }
}
INSTANTIATE_TEST_SUITE_P(Sizes, TwistOnLinear,
                         testing::Combine(testing::Values(2, 6, 18), testing::Values(50, 1000)));

// Claim: exactness does not depend on the reference path, which only centres the numbers.
TEST(Twist, AnyReferencePathGivesTheSameLikelihood) {
  LinearModel model = test::random_model(6, 3);
  const RowMatrix y = test::simulate(model, 200, 5).y;
  GaussianPath path;
  gaussian_smoother(model, y, path);
  Rng rng(4, 0);
  for (Gaussian& x : path.smoothed) x.mean += test::random_matrix(rng, 6, 1);
  Twist twist;
  make_twist(model, y, path, twist);
  TwistedGuide<PackD> guide(model, twist);
  Report report;
  ParticleFilter filter(model, guide, FilterOptions{});
  filter.run(report);
  EXPECT_NEAR(report.log_likelihood, path.log_likelihood, 1e-8);
}

// Claim: particles of the twisted filter are draws from the smoothed distribution.
TEST(Twist, ParticlesHaveTheSmoothedMoments) {
  LinearModel model = test::tracking_model();
  const RowMatrix y = test::simulate(model, 30, 5).y;
  GaussianPath path;
  gaussian_smoother(model, y, path);
  Twist twist;
  make_twist(model, y, path, twist);
  TwistedGuide<PackD> guide(model, twist);
  FilterOptions options;
  options.particles = 4000;
  ParticleFilter filter(model, guide, options);
  auto history = History<PackD>::full(2, options.particles, 30);
  Report report;
  filter.run(report, &history);
  for (int t = 0; t < 30; ++t) {
    const Cloud<PackD>& x = filter.at(history, t).x;
    const Gaussian& smoothed = path.smoothed[static_cast<std::size_t>(t)];
    for (int i = 0; i < 2; ++i) {
      const double variance = smoothed.covariance(i, i);
      double mean = 0, square = 0;
      for (int p = 0; p < options.particles; ++p) {
        const double d = x.at(p, i) - smoothed.mean(i);
        mean += d, square += d * d;
      }
      EXPECT_LT(std::abs(mean) / std::sqrt(options.particles * variance), 4.5);
      EXPECT_LT(std::abs(square / variance - options.particles),
                4.5 * std::sqrt(2.0 * options.particles));
    }
  }
}

// Claim: psi_t(x) = p(y_t | x) is the fully adapted filter, particle by particle.
TEST(Twist, ForesightOfOneIsTheAdaptedFilter) {
  LinearModel model = test::random_model(6, 9);
  RowMatrix y = test::simulate(model, 60, 5).y;
  test::punch_holes(y);
  GaussianPath path;
  gaussian_smoother(model, y, path);
  Twist twist;
  make_twist(model, y, path, twist, Foresight::kOne);
  // the two factor the first covariance differently, so all start at one point
  model.start.covariance.setZero();
  AdaptedGuide<PackD> adapted_from_point(model, y);
  TwistedGuide<PackD> twisted_from_point(model, twist);
  FilterOptions options;
  options.particles = 100;
  Report a, b;
  ParticleFilter first(model, adapted_from_point, options);
  ParticleFilter second(model, twisted_from_point, options);
  first.run(a);
  second.run(b);
  EXPECT_NEAR(a.log_likelihood, b.log_likelihood, 1e-9 * std::abs(a.log_likelihood));
  EXPECT_EQ(a.resampled, b.resampled);
  for (std::size_t t = 0; t < a.ess.size(); ++t) EXPECT_NEAR(a.ess[t], b.ess[t], 1e-6);
  for (int p = 0; p < 100; ++p) EXPECT_NEAR(first.x().at(p, 0), second.x().at(p, 0), 1e-9);
}

}  // namespace
}  // namespace fricid::smc
