// Where particles live: memory, checkpoints, lanes, float, threads.
#include <gtest/gtest.h>

#include <Eigen/Core>
#include <cstring>
#include <vector>

#include "fricid/base/parallel.hpp"
#include "fricid/smc/backward_sampling.hpp"
#include "fricid/smc/particle_filter.hpp"
#include "fricid/smc/particle_gibbs.hpp"
#include "fricid/smc/twisted_guide.hpp"
#include "friction_toy.hpp"
#include "linear_gaussian.hpp"
#include "malloc_counter.hpp"
#include "moments.hpp"

namespace fricid::smc {
namespace {

bool same_bytes(const RowMatrix& a, const RowMatrix& b) {
  return a.size() == b.size() &&
         std::memcmp(a.data(), b.data(), sizeof(double) * static_cast<std::size_t>(a.size())) == 0;
}

struct Scene {
  test::FrictionToy toy{3e-3};
  RowMatrix y;
  GaussianPath path;
  Twist twist;
  explicit Scene(int T) : y(test::simulate_toy(toy, T, 4).y) {
    y(T / 3, 0) = std::numeric_limits<double>::quiet_NaN();
    gaussian_smoother(toy, y, path);
    make_twist(toy, y, path, twist);
  }
};

/// Paths that filter and smoother find with a history of this interval.
template <class G>
std::vector<RowMatrix> smoothed(Scene& scene, G guide, int N, int interval, Report& report,
                                std::uint32_t sequence = 0) {
  using S = typename G::Lanes;
  const int T = static_cast<int>(scene.y.rows());
  FilterOptions options;
  options.particles = N;
  options.sequence = sequence;
  ParticleFilter filter(scene.toy, guide, options);
  History<S> history(3, N, T, interval);
  BackwardOptions backward;
  backward.sequence = sequence;
  BackwardWorkspace<S> ws(scene.toy.Q(), N, 8);
  std::vector<RowMatrix> paths(8);
  filter.run(report, &history);
  EXPECT_FALSE(report.failed);
  sample_paths(filter, history, backward, ws, paths, report);
  return paths;
}

TEST(History, CheckpointsGiveTheSameBytes) {
  constexpr int T = 103;
  Scene scene(T);
  const auto compare = [&](auto guide) {
    Report full, part;
    const auto expected = smoothed(scene, guide, 37, T, full);
    for (const int interval : {1, 2, 15, 102}) {
      const auto found = smoothed(scene, guide, 37, interval, part);
      for (std::size_t m = 0; m < expected.size(); ++m) {
        EXPECT_TRUE(same_bytes(found[m], expected[m])) << "interval " << interval;
      }
      EXPECT_EQ(part.backward_ess, full.backward_ess);
    }
  };
  compare(BootstrapGuide<PackD>(scene.toy, scene.y));
  compare(AdaptedGuide<PackD>(scene.toy, scene.y));
  compare(TwistedGuide<PackD>(scene.toy, scene.twist));
  compare(AdaptedGuide<PackF>(scene.toy, scene.y));
}

TEST(History, IntervalNearTheRootNeedsLittle) {
  const auto history = History<PackD>::checkpointed(3, 100, 5000);
  EXPECT_EQ(history.interval(), 100);
  EXPECT_EQ(History<PackD>::checkpointed(3, 100, 1).interval(), 1);
}

TEST(Threads, AnyNumberGivesTheSameBytes) {
  constexpr int kSequences = 8;
  const Scene scene(60);
  const auto run = [&](int jobs) {
    std::vector<RowMatrix> all(kSequences);
    parallel_for(kSequences, jobs, [&](int i) {
      Scene own = scene;
      Report report;
      all[static_cast<std::size_t>(i)] = smoothed(own, AdaptedGuide<PackD>(own.toy, own.y), 50, 60,
                                                  report, static_cast<std::uint32_t>(i))[0];
    });
    return all;
  };
  const auto expected = run(1);
  EXPECT_FALSE(same_bytes(expected[0], expected[1]));
  for (const int jobs : {2, 3, 8}) {
    const auto found = run(jobs);
    for (std::size_t i = 0; i < kSequences; ++i) EXPECT_TRUE(same_bytes(found[i], expected[i]));
  }
}

// Claim: a gather takes each lane's own particle, near or far.
template <class S>
void expect_gathered() {
  constexpr int kParticles = 100, kStates = 3;
  Cloud<S> cloud(kStates, kParticles);
  for (int p = 0; p < kParticles; ++p)
    for (int i = 0; i < kStates; ++i) cloud.set(p, i, static_cast<Real<S>>(10 * p + i));
  std::vector<int> ancestors(static_cast<std::size_t>(padded(kParticles)));
  std::vector<S> block(kStates, S(-1));
  for (const int stride : {0, 1, 2, 5, 37}) {  // ordered up to 5, over ever more blocks
    for (std::size_t k = 0; k < ancestors.size(); ++k)
      ancestors[k] = (static_cast<int>(k) * stride + 3) % kParticles;
    for (int b = 0; b < cloud.blocks(); ++b) {
      cloud.gather(b, ancestors, block.data());
      for (int k = 0; k < Cloud<S>::kLanes; ++k)
        for (int i = 0; i < kStates; ++i)
          ASSERT_EQ(lane(block[static_cast<std::size_t>(i)], k),
                    10 * ancestors[static_cast<std::size_t>(b * Cloud<S>::kLanes + k)] + i)
              << stride << " " << b;
    }
  }
}
TEST(Lanes, GatherTakesEachLanesOwnParticle) {
  expect_gathered<double>();
  expect_gathered<PackD>();
  expect_gathered<PackF>();
}

// Claim: one particle per lane is one particle at a time, to rounding of sums over weights.
TEST(Lanes, PacksAgreeWithDouble) {
  Scene scene(80);
  for (const int N : {1, 2, 15, 16, 17}) {
    SCOPED_TRACE(N);
    FilterOptions options;
    options.particles = N;
    Report one, many;
    TwistedGuide<double> scalar(scene.toy, scene.twist);
    TwistedGuide<PackD> packs(scene.toy, scene.twist);
    ParticleFilter a(scene.toy, scalar, options);
    ParticleFilter b(scene.toy, packs, options);
    a.run(one);
    b.run(many);
    EXPECT_NEAR(one.log_likelihood, many.log_likelihood, 1e-9);
    for (int p = 0; p < N; ++p) {
      for (int i = 0; i < 3; ++i) EXPECT_NEAR(a.x().at(p, i), b.x().at(p, i), 1e-12);
    }
  }
}

// Claim: float particles give the double likelihood to the Monte Carlo error and better where
// nothing is resampled: positions of 0.1 rad carry 1e-8 of rounding against 1e-5 of noise.
TEST(Float, LikelihoodIsThatOfDouble) {
  Scene scene(300);
  FilterOptions options;
  options.particles = 200;
  Report d, f;
  TwistedGuide<PackD> twisted_d(scene.toy, scene.twist);
  TwistedGuide<PackF> twisted_f(scene.toy, scene.twist);
  ParticleFilter(scene.toy, twisted_d, options).run(d);
  ParticleFilter(scene.toy, twisted_f, options).run(f);
  EXPECT_NEAR(f.log_likelihood, d.log_likelihood, 0.05);

  test::Mean difference;
  AdaptedGuide<PackD> adapted_d(scene.toy, scene.y);
  AdaptedGuide<PackF> adapted_f(scene.toy, scene.y);
  for (std::uint32_t sequence = 0; sequence < 60; ++sequence) {
    options.sequence = sequence;
    ParticleFilter(scene.toy, adapted_d, options).run(d);
    ParticleFilter(scene.toy, adapted_f, options).run(f);
    difference.add(f.log_likelihood - d.log_likelihood);
  }
  EXPECT_LT(std::abs(difference.z(0)), 4.5);
  EXPECT_LT(difference.standard_error(), 0.5);
}

TEST(Float, SmoothedPathsAreThoseOfDouble) {
  Scene scene(300);
  Report report;
  test::Mean v;
  for (std::uint32_t sequence = 0; sequence < 30; ++sequence) {
    const auto d =
        smoothed(scene, TwistedGuide<PackD>(scene.toy, scene.twist), 100, 300, report, sequence);
    const auto f =
        smoothed(scene, TwistedGuide<PackF>(scene.toy, scene.twist), 100, 300, report, sequence);
    double sum = 0;
    for (std::size_t m = 0; m < d.size(); ++m) sum += f[m](150, 1) - d[m](150, 1);
    v.add(sum / 8);
  }
  EXPECT_LT(std::abs(v.z(0)), 4.5);
}

/// Heap blocks that one more run of filter and smoother takes.
template <class G>
long blocks_of_a_run(Scene& scene, G guide, Backward method) {
  using S = typename G::Lanes;
  const int T = static_cast<int>(scene.y.rows());
  FilterOptions options;
  options.particles = 50;
  options.y = &scene.y;
  ParticleFilter filter(scene.toy, guide, options);
  auto history = History<S>::checkpointed(3, 50, T);
  BackwardOptions backward;
  backward.method = method;
  BackwardWorkspace<S> ws(scene.toy.Q(), 50, 8, backward.moves);
  std::vector<RowMatrix> paths(8);
  Report report;
  long before = 0;
  for (int run = 0; run < 2; ++run) {
    before = test::heap_blocks();
    filter.run(report, &history);
    sample_paths(filter, history, backward, ws, paths, report);
  }
  EXPECT_FALSE(report.failed);
  return test::heap_blocks() - before;
}

TEST(Allocation, TheCounterSeesEigenAndNew) {
  const long before = test::heap_blocks();
  const Eigen::MatrixXd A = Eigen::MatrixXd::Zero(50, 50);
  const std::vector<double> v(static_cast<std::size_t>(A.size()), A(0, 0));
  EXPECT_GE(test::heap_blocks() - before, v.empty() ? 3 : 2);
}

TEST(Allocation, FilterAndSmootherTakeNothingFromTheHeap) {
  Scene scene(60);
  for (const Backward method : {Backward::kExact, Backward::kMoves, Backward::kTrace}) {
    EXPECT_EQ(blocks_of_a_run(scene, BootstrapGuide<PackD>(scene.toy, scene.y), method), 0);
    EXPECT_EQ(blocks_of_a_run(scene, AdaptedGuide<PackD>(scene.toy, scene.y), method), 0);
    EXPECT_EQ(blocks_of_a_run(scene, AdaptedGuide<PackF>(scene.toy, scene.y), method), 0);
    EXPECT_EQ(blocks_of_a_run(scene, TwistedGuide<PackD>(scene.toy, scene.twist), method), 0);
  }
}

TEST(Allocation, ABentLookAheadTakesNothingFromTheHeap) {
  Scene scene(60);
  const Kink kink{1, Eigen::Vector3d(1, 0, 0), 0.1, Quadratic::zero(3)};
  scene.twist.bend.assign(59, Quadratic::zero(3));
  scene.twist.kink.assign(59, kink);
  scene.twist.kink[0].state = -1;
  EXPECT_EQ(blocks_of_a_run(scene, TwistedGuide<PackD>(scene.toy, scene.twist), Backward::kTrace),
            0);
  EXPECT_EQ(blocks_of_a_run(scene, TwistedGuide<PackF>(scene.toy, scene.twist), Backward::kTrace),
            0);
}

TEST(Allocation, AGibbsSweepTakesNothingFromTheHeap) {
  Scene scene(60);
  AdaptedGuide<PackD> guide(scene.toy, scene.y);
  FilterOptions options;
  options.particles = 20;
  ParticleGibbs gibbs(scene.toy, guide, options);
  std::vector<RowMatrix> paths(1);
  sample_gaussian_paths(scene.toy.Q(), scene.path, 1, 0, paths);
  ASSERT_TRUE(gibbs.sweep(paths[0], 0));
  const long before = test::heap_blocks();
  for (std::uint32_t sweep = 1; sweep < 5; ++sweep) ASSERT_TRUE(gibbs.sweep(paths[0], sweep));
  EXPECT_EQ(test::heap_blocks(), before);
}

// Many states and channels missing in changing patterns: the large matrices of the guides.
TEST(Allocation, WideModelsTakeNothingFromTheHeap) {
  LinearModel model = test::random_model(24, 5);
  RowMatrix y = test::simulate(model, 40, 6).y;
  test::punch_holes(y);
  GaussianPath path;
  gaussian_smoother(model, y, path);
  Twist twist;
  make_twist(model, y, path, twist);
  const auto blocks = [&](auto guide) {
    FilterOptions options;
    options.particles = 30;
    options.y = &y;
    ParticleFilter filter(model, guide, options);
    Report report;
    filter.run(report);
    const long before = test::heap_blocks();
    filter.run(report);
    EXPECT_FALSE(report.failed);
    return test::heap_blocks() - before;
  };
  EXPECT_EQ(blocks(BootstrapGuide<PackD>(model, y)), 0);
  EXPECT_EQ(blocks(AdaptedGuide<PackD>(model, y)), 0);
  EXPECT_EQ(blocks(TwistedGuide<PackD>(model, twist)), 0);
}

/// A filter whose observations come one by one.
class Online {
 public:
  Online(Scene& scene, int N)
      : scene_(&scene),
        ring_(scene.y.topRows(1)),
        guide_(scene.toy, ring_, std::numeric_limits<int>::max()),
        filter_(scene.toy, guide_, FilterOptions{.particles = N}),
        log_likelihood(guide_.log_start()) {
    filter_.start();
  }
  void step(int t) {
    ring_(0, 0) = scene_->y(t + 1, 0);
    log_likelihood += filter_.weigh(t)->log_sum;
    filter_.move(t);
  }
  auto& filter() { return filter_; }

 private:
  Scene* scene_;
  RowMatrix ring_;
  AdaptedGuide<PackD> guide_;
  ParticleFilter<test::FrictionToy, AdaptedGuide<PackD>> filter_;

 public:
  double log_likelihood;
};

TEST(Online, StepsAreThoseOfARunAndTakeNothingFromTheHeap) {
  Scene scene(60);
  AdaptedGuide<PackD> guide(scene.toy, scene.y);
  Report report;
  ParticleFilter(scene.toy, guide, FilterOptions{.particles = 50}).run(report);
  Online online(scene, 50);
  online.step(0);
  const long before = test::heap_blocks();
  for (int t = 1; t < 59; ++t) online.step(t);
  EXPECT_EQ(test::heap_blocks(), before);
  EXPECT_EQ(online.log_likelihood, report.log_likelihood);
}

TEST(Online, ARestoredFilterGoesOnToTheLastBit) {
  Scene scene(60);
  Online online(scene, 50);
  for (int t = 0; t < 30; ++t) online.step(t);
  FilterState<PackD> state;
  online.filter().save(state);
  const double before = online.log_likelihood;
  for (int t = 30; t < 59; ++t) online.step(t);
  const double after = online.log_likelihood, q = online.filter().x().at(7, 0);

  Online other(scene, 50);
  other.filter().restore(state);
  other.log_likelihood = before;
  for (int t = 30; t < 59; ++t) other.step(t);
  EXPECT_EQ(other.log_likelihood, after);
  EXPECT_EQ(other.filter().x().at(7, 0), q);
}

}  // namespace
}  // namespace fricid::smc
