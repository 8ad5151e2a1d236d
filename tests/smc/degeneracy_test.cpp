// G: what goes wrong with particle filters on friction, and whether the report says so.
#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

#include "fricid/smc/backward_sampling.hpp"
#include "fricid/smc/particle_filter.hpp"
#include "fricid/smc/twisted_guide.hpp"
#include "friction_toy.hpp"
#include "moments.hpp"

namespace fricid::smc {
namespace {

constexpr int kSteps = 300, kParticles = 200;

bool warns(const Report& report, const std::string& about) {
  const auto list = report.warnings();
  return std::any_of(list.begin(), list.end(), [&](const Warning& w) {
    return w.figure.find(about) != std::string::npos && !w.meaning.empty() && !w.remedy.empty();
  });
}

/// B runs of filter and exact smoother.
struct Runs {
  test::Mean ell;
  double lowest = 1e300, highest = -1e300;
  std::vector<Report> reports;
  double spread() const { return ell.standard_error() * std::sqrt(double(reports.size())); }
};
template <class G>
Runs repeat(test::FrictionToy& toy, G guide, int B, const RowMatrix* y = nullptr) {
  using S = typename G::Lanes;
  FilterOptions options;
  options.particles = kParticles;
  options.y = y;
  auto history = History<S>::full(3, kParticles, kSteps);
  BackwardWorkspace<S> ws(toy.Q(), kParticles, 16);
  std::vector<RowMatrix> paths(16);
  Runs runs;
  for (int b = 0; b < B; ++b) {
    options.sequence = static_cast<std::uint32_t>(b);
    ParticleFilter filter(toy, guide, options);
    Report report;
    filter.run(report, &history);
    sample_paths(filter, history, BackwardOptions{}, ws, paths, report);
    EXPECT_FALSE(report.failed);
    EXPECT_TRUE(std::isfinite(report.log_likelihood));
    runs.ell.add(report.log_likelihood);
    runs.reports.push_back(report);
  }
  return runs;
}

struct DegenerateScene {
  test::FrictionToy toy;
  RowMatrix y;
  GaussianPath path;
  Twist twist;
  explicit DegenerateScene(double sd_v) : toy(sd_v), y(test::simulate_toy(toy, kSteps, 3).y) {
    smooth();
  }
  void smooth() {
    gaussian_smoother(toy, y, path);
    make_twist(toy, y, path, twist);
  }
};

class Sweep : public testing::TestWithParam<double> {};

TEST_P(Sweep, TwistedFilterIsExactEnoughAndWarningsFireWhenDue) {
  DegenerateScene scene(GetParam());
  const Runs twisted = repeat(scene.toy, TwistedGuide<PackD>(scene.toy, scene.twist), 10);
  EXPECT_LT(twisted.spread(), 0.1);
  for (const Report& r : twisted.reports) {
    EXPECT_GE(r.distinct_roots, 0.9 * kParticles);
    EXPECT_FALSE(warns(r, "distinct roots"));
  }
  const Runs bootstrap = repeat(scene.toy, BootstrapGuide<PackD>(scene.toy, scene.y), 10, &scene.y);
  const Runs adapted = repeat(scene.toy, AdaptedGuide<PackD>(scene.toy, scene.y), 10, &scene.y);
  for (const Runs* runs : {&bootstrap, &adapted}) {
    for (const Report& r : runs->reports) {
      for (const double x : r.backward_ess) EXPECT_TRUE(x >= 0.999 && x <= kParticles);
      for (const double x : r.nis) EXPECT_TRUE(std::isfinite(x));
      EXPECT_EQ(warns(r, "backward ESS"), r.median_backward_ess() < 3);
      EXPECT_EQ(warns(r, "refreshed"), r.refreshed < 0.2);
      EXPECT_TRUE(warns(r, "distinct roots"));
    }
  }
}
INSTANTIATE_TEST_SUITE_P(NoiseOfVelocity, Sweep,
                         testing::Values(3e-2, 1e-2, 3e-3, 1e-3, 1e-4, 1e-5, 1e-6));

// The ends of the sweep: the bootstrap filter has one past for each future at either.
TEST(Degeneracy, BootstrapAtTheEndsOfTheSweepSetsTheAlarms) {
  for (const double sd_v : {3e-2, 1e-6}) {
    DegenerateScene scene(sd_v);
    const Runs runs = repeat(scene.toy, BootstrapGuide<PackD>(scene.toy, scene.y), 3, &scene.y);
    for (const Report& r : runs.reports) {
      EXPECT_TRUE(warns(r, "backward ESS")) << r.median_backward_ess();
      EXPECT_TRUE(sd_v < 1e-2 || warns(r, "refreshed")) << r.refreshed;
    }
  }
}

TEST(Degeneracy, AdaptedBeatsBootstrap) {
  DegenerateScene scene(1e-2);
  const Runs bootstrap = repeat(scene.toy, BootstrapGuide<PackD>(scene.toy, scene.y), 20);
  const Runs adapted = repeat(scene.toy, AdaptedGuide<PackD>(scene.toy, scene.y), 20);
  EXPECT_GT(bootstrap.spread(), 3 * adapted.spread());
}

// Claim: log Z is where a log-normal estimate has it, mean + var / 2.
TEST(Degeneracy, TwistedAndAdaptedAgreeOnTheLikelihood) {
  constexpr int kRuns = 200;
  DegenerateScene scene(3e-3);
  const Runs twisted = repeat(scene.toy, TwistedGuide<PackD>(scene.toy, scene.twist), 10);
  const Runs adapted = repeat(scene.toy, AdaptedGuide<PackD>(scene.toy, scene.y), kRuns);
  const double variance = adapted.spread() * adapted.spread();
  const double standard_error = std::sqrt(variance / kRuns + variance * variance / (2 * kRuns));
  EXPECT_LT(std::abs(twisted.ell.value() - adapted.ell.value() - variance / 2),
            4.5 * standard_error);
}

TEST(Degeneracy, WrongStiffnessWithTinyNoiseSetsTheAlarms) {
  DegenerateScene scene(1e-3);
  scene.toy.stiffness *= 1.5;
  scene.toy.set_noise(1e-6, 1e-4, 1e-6);
  scene.smooth();
  const Runs twisted = repeat(scene.toy, TwistedGuide<PackD>(scene.toy, scene.twist), 3);
  const Runs adapted = repeat(scene.toy, AdaptedGuide<PackD>(scene.toy, scene.y), 3, &scene.y);
  for (const Report& r : twisted.reports) EXPECT_TRUE(warns(r, "distinct roots"));
  for (const Report& r : adapted.reports) {
    EXPECT_TRUE(warns(r, "distinct roots"));
    EXPECT_TRUE(warns(r, "NIS"));
    EXPECT_TRUE(warns(r, "backward ESS"));
  }
}

}  // namespace
}  // namespace fricid::smc
