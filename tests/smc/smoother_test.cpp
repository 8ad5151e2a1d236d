// Smoothers against RTS, with lag-one covariances. Particle Gibbs keeps the posterior.
#include <gtest/gtest.h>

#include "fricid/smc/backward_sampling.hpp"
#include "fricid/smc/fixed_lag.hpp"
#include "fricid/smc/particle_filter.hpp"
#include "fricid/smc/particle_gibbs.hpp"
#include "fricid/smc/twisted_guide.hpp"
#include "linear_gaussian.hpp"
#include "moments.hpp"

namespace fricid::smc {
namespace {

constexpr int kSteps = 20;

/// The model turns by 40 degrees a step, so that a state taken for its neighbour is far off.
struct Scene {
  LinearModel model = test::tracking_model();
  RowMatrix y;
  GaussianPath path;
  Twist twist;
  Scene() {
    model.A = Eigen::MatrixXd{{0.7, 0.6}, {-0.6, 0.7}};
    y = test::simulate(model, kSteps, 8).y;
    test::punch_holes(y);
    gaussian_smoother(model, y, path);
    make_twist(model, y, path, twist);
  }
};

/// Runs filter and smoother B times and compares the paths' moments with RTS.
template <class G>
void expect_smoothed_paths(Scene& scene, G guide, Backward method, int N, int M, int B) {
  using S = typename G::Lanes;
  test::PathMoments moments(scene.path);
  FilterOptions filter_options;
  filter_options.particles = N;
  BackwardOptions options;
  options.method = method;
  auto history = History<S>::full(2, N, kSteps);
  BackwardWorkspace<S> ws(scene.model.Q(), N, M, options.moves);
  std::vector<RowMatrix> paths(static_cast<std::size_t>(M));
  Report report;
  for (int b = 0; b < B; ++b) {
    options.sequence = filter_options.sequence = static_cast<std::uint32_t>(b);
    ParticleFilter filter(scene.model, guide, filter_options);
    filter.run(report, &history);
    sample_paths(filter, history, options, ws, paths, report);
    ASSERT_FALSE(report.failed);
    moments.add(paths);
  }
  moments.expect_smoothed();
}

TEST(BackwardSampling, ExactPathsAreSmoothed) {
  Scene scene;
  expect_smoothed_paths(scene, AdaptedGuide<PackD>(scene.model, scene.y), Backward::kExact, 1003,
                        40, 100);
}
TEST(BackwardSampling, ExactPathsOfTheBootstrapFilterAreSmoothed) {
  Scene scene;
  expect_smoothed_paths(scene, BootstrapGuide<PackD>(scene.model, scene.y), Backward::kExact, 1003,
                        40, 100);
}
TEST(BackwardSampling, ExactPathsOfTheTwistedFilterAreSmoothed) {
  Scene scene;
  expect_smoothed_paths(scene, TwistedGuide<PackD>(scene.model, scene.twist), Backward::kExact,
                        1003, 40, 100);
}
TEST(BackwardSampling, MovedPathsAreSmoothed) {
  Scene scene;
  expect_smoothed_paths(scene, AdaptedGuide<PackD>(scene.model, scene.y), Backward::kMoves, 1003,
                        40, 100);
}
TEST(BackwardSampling, TracedPathsAreSmoothed) {
  Scene scene;
  expect_smoothed_paths(scene, AdaptedGuide<PackD>(scene.model, scene.y), Backward::kTrace, 3003,
                        100, 100);
  expect_smoothed_paths(scene, TwistedGuide<PackD>(scene.model, scene.twist), Backward::kTrace, 203,
                        203, 100);
}

// Reference: the kernel written out.
TEST(BackwardKernel, DrawsFromTheBackwardWeights) {
  constexpr int N = 21, n = 3;
  Rng rng(5, 0);
  const Eigen::MatrixXd Q = test::random_covariance(rng, n, 0.5);
  Slice<PackD> slice{Cloud<PackD>(n, N), Cloud<PackD>(n, N), std::vector<double>(32),
                     std::vector<int>(32)};
  for (int p = 0; p < N; ++p) {
    slice.log_weights[static_cast<std::size_t>(p)] = rng.normal();
    for (int i = 0; i < n; ++i) slice.image.set(p, i, 1e3 + rng.normal());
  }
  slice.log_weights[4] = -std::numeric_limits<double>::infinity();
  const std::vector<double> x = {1e3 + 0.3, 1e3 - 0.2, 1e3 + 0.5};
  std::vector<double> expected(N);
  double total = 0, square = 0;
  for (int p = 0; p < N; ++p) {
    Eigen::Vector3d d;
    for (int i = 0; i < n; ++i) d(i) = x[static_cast<std::size_t>(i)] - slice.image.at(p, i);
    auto& w = expected[static_cast<std::size_t>(p)];
    w = std::exp(slice.log_weights[static_cast<std::size_t>(p)] - 0.5 * d.dot(Q.inverse() * d));
    total += w, square += w * w;
  }
  BackwardKernel<PackD> kernel(Q, N);
  kernel.prepare(slice);
  kernel.aim(x);
  // an even grid of u hits each particle in proportion to its weight
  constexpr int kDraws = 100'000;
  std::vector<int> count(N, 0);
  double ess = 0;
  for (int k = 0; k < kDraws; ++k) {
    ++count.at(static_cast<std::size_t>(kernel.draw((k + 0.5) / kDraws, ess)));
  }
  EXPECT_NEAR(ess, total * total / square, 1e-9);
  for (std::size_t p = 0; p < N; ++p) EXPECT_NEAR(count[p], expected[p] / total * kDraws, 2);
  EXPECT_EQ(count[4], 0);
  for (double u : {1e-17, 1 - 1e-16}) EXPECT_GE(kernel.draw(u, ess), 0);

  for (double& lw : slice.log_weights) lw = -std::numeric_limits<double>::infinity();
  kernel.prepare(slice);
  kernel.aim(x);
  EXPECT_EQ(kernel.draw(0.5, ess), -1);
  EXPECT_EQ(ess, 0);
}

// Claim: with a lag as long as the data it is the smoother, with lag 0 the filter.
TEST(FixedLag, LiesBetweenFilterAndSmoother) {
  Scene scene;
  for (const int lag : {0, kSteps}) {
    std::vector<test::Mean> means(kSteps), variances(kSteps);
    for (std::uint32_t b = 0; b < 60; ++b) {
      BootstrapGuide<PackD> guide(scene.model, scene.y);
      FilterOptions options;
      options.particles = 2000;
      options.sequence = b;
      ParticleFilter filter(scene.model, guide, options);
      FixedLagSmoother smoother(filter, lag);
      FixedLagEstimate estimate;
      ASSERT_TRUE(smoother.run(estimate));
      for (int t = 0; t < kSteps; ++t) {
        means[static_cast<std::size_t>(t)].add(estimate.mean(t, 1));
        variances[static_cast<std::size_t>(t)].add(estimate.variance(t, 1));
      }
    }
    const auto& reference = lag == 0 ? scene.path.filtered : scene.path.smoothed;
    for (std::size_t t = 0; t < kSteps; ++t) {
      EXPECT_LT(std::abs(means[t].z(reference[t].mean(1))), 4.5) << lag << " " << t;
      // a weighted variance is low by about a share of 1 / ESS
      EXPECT_NEAR(variances[t].value() / reference[t].covariance(1, 1), 1, 0.05) << lag << " " << t;
    }
  }
}

// An exact draw of the posterior is one after some sweeps too, whatever N.
template <class G>
void expect_invariance(Scene& scene, G guide, int N) {
  constexpr std::uint32_t kReplications = 2000, kSweeps = 6;
  std::vector<RowMatrix> draws(kReplications);
  sample_gaussian_paths(scene.model.Q(), scene.path, 3, static_cast<std::uint32_t>(N), draws);
  FilterOptions options;
  options.particles = N;
  ParticleGibbs gibbs(scene.model, guide, options);
  test::PathMoments moments(scene.path);
  std::vector<int> bins(20, 0);
  double moved = 0;
  for (std::uint32_t r = 0; r < kReplications; ++r) {
    RowMatrix path = draws[r];
    for (std::uint32_t k = 0; k < kSweeps; ++k) {
      ASSERT_TRUE(gibbs.sweep(path, kSweeps * r + k));
    }
    moments.add({&path, 1});
    moved += (path.row(kSteps / 2) - draws[r].row(kSteps / 2)).norm() > 0 ? 1 : 0;
    const Gaussian& x = scene.path.smoothed[kSteps / 2];
    const double z = (path(kSteps / 2, 0) - x.mean(0)) / std::sqrt(x.covariance(0, 0));
    ++bins[static_cast<std::size_t>(20 * 0.5 * std::erfc(-z / std::sqrt(2.0)))];
  }
  moments.expect_smoothed();
  EXPECT_GT(moved / kReplications, N == 2 ? 0.1 : 0.5);
  double chi2 = 0;
  for (const int count : bins)
    chi2 += std::pow(count - kReplications / 20.0, 2) / (kReplications / 20.0);
  EXPECT_LT(chi2, 54);  // 19 degrees of freedom, p = 3e-5
}

TEST(ParticleGibbs, SweepsKeepThePosterior) {
  Scene scene;
  for (const int N : {2, 5, 20}) {
    SCOPED_TRACE(N);
    expect_invariance(scene, BootstrapGuide<PackD>(scene.model, scene.y), N);
    expect_invariance(scene, AdaptedGuide<PackD>(scene.model, scene.y), N);
    expect_invariance(scene, TwistedGuide<PackD>(scene.model, scene.twist), N);
  }
}

}  // namespace
}  // namespace fricid::smc
