// Particle filters against the Kalman filter.
#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <string>
#include <vector>

#include "fricid/base/math.hpp"
#include "fricid/smc/particle_filter.hpp"
#include "linear_gaussian.hpp"
#include "moments.hpp"

namespace fricid::smc {
namespace {

struct Estimates {
  double mean_ratio, standard_error, mean_log, sd_log;
};

/// B runs of a filter: mean of Zhat / Z and what log Zhat - log Z is like.
template <class G>
Estimates repeat(LinearModel& model, const RowMatrix& y, int N, int B, double ell,
                 Resampling scheme = Resampling::kSystematic, double renewed = 1) {
  G guide(model, y);
  FilterOptions options;
  options.renewed = renewed;
  options.particles = N;
  options.resampling = scheme;
  Report report;
  double sum = 0, square = 0, log_sum = 0, log_square = 0;
  for (int b = 0; b < B; ++b) {
    options.sequence = static_cast<std::uint32_t>(b);
    ParticleFilter filter(model, guide, options);
    filter.run(report);
    EXPECT_FALSE(report.failed);
    const double d = report.log_likelihood - ell, ratio = std::exp(d);
    sum += ratio, square += ratio * ratio, log_sum += d, log_square += d * d;
  }
  const double mean = sum / B, mean_log = log_sum / B;
  return {mean, std::sqrt((square / B - mean * mean) / B), mean_log,
          std::sqrt(log_square / B - mean_log * mean_log)};
}

struct Scene {
  LinearModel model = test::tracking_model();
  RowMatrix y;
  double ell;
  explicit Scene(int T, bool holes = false) {
    y = test::simulate(model, T, 21).y;
    if (holes) test::punch_holes(y);
    GaussianPath path;
    gaussian_filter(model, y, path);
    ell = path.log_likelihood;
  }
};

TEST(ParticleFilter, LikelihoodIsUnbiased) {
  for (const bool holes : {false, true}) {
    Scene scene(50, holes);
    const auto bootstrap = repeat<BootstrapGuide<PackD>>(scene.model, scene.y, 203, 400, scene.ell);
    const auto adapted = repeat<AdaptedGuide<PackD>>(scene.model, scene.y, 203, 400, scene.ell);
    for (const auto& e : {bootstrap, adapted}) {
      EXPECT_LT(std::abs(e.mean_ratio - 1) / e.standard_error, 4.5);
      EXPECT_LT(e.sd_log, 0.7);
      // log-normal: E log Zhat = log Z - var / 2
      EXPECT_LT(std::abs(e.mean_log + 0.5 * e.sd_log * e.sd_log), 4.5 * e.sd_log / 20 + 0.02);
    }
    EXPECT_LT(adapted.sd_log, bootstrap.sd_log);
  }
}

TEST(ParticleFilter, EverySchemeOfResamplingIsUnbiased) {
  Scene scene(30);
  for (const Resampling scheme :
       {Resampling::kStratified, Resampling::kMultinomial, Resampling::kKilling}) {
    const auto e = repeat<AdaptedGuide<PackD>>(scene.model, scene.y, 100, 400, scene.ell, scheme);
    EXPECT_LT(std::abs(e.mean_ratio - 1) / e.standard_error, 4.5);
  }
  const auto few = repeat<AdaptedGuide<PackD>>(scene.model, scene.y, 100, 400, scene.ell,
                                               Resampling::kSystematic, 0.1);
  EXPECT_LT(std::abs(few.mean_ratio - 1) / few.standard_error, 4.5);
}

TEST(ParticleFilter, SpreadFallsWithTheRootOfN) {
  Scene scene(50);
  const auto sd = [&](int N) {
    return repeat<AdaptedGuide<PackD>>(scene.model, scene.y, N, 300, scene.ell).sd_log;
  };
  EXPECT_NEAR(std::log(sd(800) / sd(50)) / std::log(16.0), -0.5, 0.1);
}

TEST(ParticleFilter, MeansAreThoseOfTheKalmanFilter) {
  Scene scene(40, true);
  GaussianPath path;
  gaussian_filter(scene.model, scene.y, path);
  BootstrapGuide<PackD> guide(scene.model, scene.y);
  std::vector<test::Mean> mean(40);
  for (std::uint32_t b = 0; b < 40; ++b) {
    FilterOptions options;
    options.particles = 1000;
    options.sequence = b;
    ParticleFilter filter(scene.model, guide, options);
    filter.start();
    for (int t = 0; t < 40; ++t) {
      ASSERT_TRUE(filter.weigh(t));
      double sum = 0;
      for (int p = 0; p < 1000; ++p) {
        sum += filter.weights()[static_cast<std::size_t>(p)] * filter.x().at(p, 1);
      }
      mean[static_cast<std::size_t>(t)].add(sum);
      if (t < 39) filter.move(t);
    }
  }
  for (std::size_t t = 0; t < 40; ++t) {
    EXPECT_LT(std::abs(mean[t].z(path.filtered[t].mean(1))), 4.5);
  }
}

// Claim: the NIS of the particles is that of the Kalman filter to their Monte Carlo error.
TEST(ParticleFilter, InnovationsAreThoseOfTheKalmanFilter) {
  for (const int n : {2, 6}) {
    LinearModel model = test::random_model(n, 3);
    RowMatrix y = test::simulate(model, 60, 5).y;
    test::punch_holes(y);
    GaussianPath path;
    gaussian_filter(model, y, path);
    AdaptedGuide<PackD> guide(model, y);
    FilterOptions options;
    options.particles = 20'000;
    options.y = &y;
    Report report;
    ParticleFilter filter(model, guide, options);
    filter.run(report);
    EXPECT_EQ(report.present, path.present);
    for (std::size_t t = 0; t < 60; ++t) {
      EXPECT_NEAR(report.nis[t], path.nis[t], 0.05 * (1 + path.nis[t])) << t;
    }
  }
}

/// log density of a Cauchy error of scale 0.3, -inf when `impossible`.
struct CauchyObservation {
  const RowMatrix* y;
  int impossible_at = -1;
  int now = 0;
  int steps() const { return static_cast<int>(y->rows()); }
  void prepare(int t) { now = t; }
  PackD operator()(const PackD* x) const {
    if (now == impossible_at) return PackD(-std::numeric_limits<double>::infinity());
    const PackD r = (PackD((*y)(now, 0)) - x[0]) / PackD(0.3);
    return -log(PackD(M_PI * 0.3)) - log1p(r * r);
  }
};

LinearModel scalar_model() {
  LinearModel model;
  model.A = Eigen::MatrixXd{{0.9}};
  model.b = Eigen::VectorXd{{0.1}};
  model.start = {Eigen::VectorXd{{0.0}}, Eigen::MatrixXd{{1.0}}};
  model.noise = Eigen::MatrixXd{{0.2}};
  model.observe = model.error = Eigen::MatrixXd{{1.0}};
  return model;
}

// Reference: the same recursion of densities on a grid.
TEST(ParticleFilter, AnyObservationDensityWillDo) {
  constexpr int T = 25, kGrid = 801;
  LinearModel model = scalar_model();
  const RowMatrix y = test::simulate(model, T, 4).y;
  const double h = 16.0 / (kGrid - 1);
  const auto point = [&](int i) { return -8 + h * i; };
  const auto normal = [](double d, double variance) {
    return std::exp(-0.5 * d * d / variance) / std::sqrt(2 * M_PI * variance);
  };
  std::vector<double> density(kGrid), next(kGrid);
  for (int i = 0; i < kGrid; ++i) density[static_cast<std::size_t>(i)] = normal(point(i), 1);
  double ell = 0;
  for (int t = 0; t < T; ++t) {
    double sum = 0;
    for (int i = 0; i < kGrid; ++i) {
      const double r = (y(t, 0) - point(i)) / 0.3;
      sum += h * (density[static_cast<std::size_t>(i)] /= M_PI * 0.3 * (1 + r * r));
    }
    ell += std::log(sum);
    for (int j = 0; j < kGrid; ++j) {
      double total = 0;
      for (int i = 0; i < kGrid; ++i) {
        total += density[static_cast<std::size_t>(i)] / sum *
                 normal(point(j) - 0.9 * point(i) - 0.1, 0.2);
      }
      next[static_cast<std::size_t>(j)] = h * total;
    }
    density = next;
  }
  test::Mean ratio;
  Report report;
  BootstrapGuide<PackD, CauchyObservation> guide(model, CauchyObservation{&y});
  for (std::uint32_t b = 0; b < 200; ++b) {
    FilterOptions options;
    options.particles = 2000;
    options.sequence = b;
    ParticleFilter(model, guide, options).run(report);
    ratio.add(std::exp(report.log_likelihood - ell));
  }
  EXPECT_LT(std::abs(ratio.z(1)), 4.5);
  EXPECT_LT(ratio.standard_error(), 0.1);
}

TEST(ParticleFilter, WhenAllWeightsVanishTheReportSaysWhere) {
  LinearModel model = scalar_model();
  const RowMatrix y = test::simulate(model, 10, 4).y;
  BootstrapGuide<PackD, CauchyObservation> guide(model, CauchyObservation{&y, 6});
  Report report;
  FilterOptions options;
  options.y = &y;
  ParticleFilter(model, guide, options).run(report);
  EXPECT_TRUE(report.failed);
  EXPECT_EQ(report.steps, 6);
  EXPECT_EQ(report.log_likelihood, -std::numeric_limits<double>::infinity());
  EXPECT_GT(report.min_ess(), 1);
  ASSERT_EQ(report.warnings().size(), 1u);
  EXPECT_NE(report.warnings()[0].figure.find("observation 6"), std::string::npos);
}

TEST(ParticleFilter, WorksForAnyNumberOfParticles) {
  Scene scene(20, true);
  Report report;
  for (const int N : {1, 2, 3, 7, 8, 9, 16, 17, 33}) {
    FilterOptions options;
    options.particles = N;
    AdaptedGuide<PackD> d(scene.model, scene.y);
    AdaptedGuide<PackF> f(scene.model, scene.y);
    ParticleFilter(scene.model, d, options).run(report);
    EXPECT_TRUE(!report.failed && std::isfinite(report.log_likelihood));
    EXPECT_GE(report.distinct_roots, 1);
    for (const double ess : report.ess) EXPECT_TRUE(ess >= 1 - 1e-9 && ess <= N + 1e-9);
    const double in_double = report.log_likelihood;
    ParticleFilter(scene.model, f, options).run(report);
    EXPECT_NEAR(report.log_likelihood, in_double, 2 + 20.0 / N);
  }
}

}  // namespace
}  // namespace fricid::smc
