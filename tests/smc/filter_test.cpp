// A2: particle filters against the Kalman filter.
#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "fricid/smc/particle_filter.hpp"
#include "linear_gaussian.hpp"

namespace fricid::smc {
namespace {

struct Estimates {
  double mean_ratio, standard_error, mean_log, sd_log;
};

/// B runs of a filter: mean of Zhat / Z and what log Zhat - log Z is like.
template <class G>
Estimates repeat(LinearModel& model, const RowMatrix& y, int N, int B, double ell,
                 Resampling scheme = Resampling::kSystematic) {
  G guide(model, y);
  FilterOptions options;
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

}  // namespace
}  // namespace fricid::smc
