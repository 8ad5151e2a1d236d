// Filters and smoothers: `items_per_second` counts particle-steps, or pairs. The linear model has
// 18 states of which 6 are observed, the toy is one joint with a bristle.
#include <benchmark/benchmark.h>

#include <vector>

#include "fricid/smc/backward_sampling.hpp"
#include "fricid/smc/particle_filter.hpp"
#include "fricid/smc/twisted_guide.hpp"
#include "smc/friction_toy.hpp"
#include "smc/linear_gaussian.hpp"

namespace fricid::smc {
namespace {

/// Six joints as far as the sizes go: y = q, diagonal noise.
LinearModel six_joints() {
  LinearModel model = test::random_model(18, 3);
  model.observe = Eigen::MatrixXd::Identity(6, 18);
  model.noise = Eigen::VectorXd::LinSpaced(18, 0.05, 0.2).asDiagonal();
  model.error = Eigen::MatrixXd::Identity(6, 6) * 0.01;
  return model;
}

struct Linear {
  LinearModel model = six_joints();
  RowMatrix y;
  explicit Linear(int T) : y(test::simulate(model, T, 2).y) {}
};
struct Toy {
  test::FrictionToy model{3e-3};
  RowMatrix y;
  explicit Toy(int T) : y(test::simulate_toy(model, T, 2).y) {}
};

/// The guide G of a scene; the path that the twisted one is centred on is made outside the timing.
template <class G, class Scene>
struct Guided {
  Scene scene;
  GaussianPath path;
  Twist twist;
  explicit Guided(int T) : scene(T) {}
  G guide() {
    if constexpr (std::same_as<G, TwistedGuide<typename G::Lanes>>) {
      gaussian_smoother(scene.model, scene.y, path);
      make_twist(scene.model, scene.y, path, twist);
      return G(scene.model, twist);
    } else {
      return G(scene.model, scene.y);
    }
  }
};

template <class G, class Scene>
void run_filter(benchmark::State& state) {
  const int N = static_cast<int>(state.range(0)), T = static_cast<int>(state.range(1));
  Guided<G, Scene> guided(T);
  G guide = guided.guide();
  FilterOptions options;
  options.particles = N;
  ParticleFilter filter(guided.scene.model, guide, options);
  Report report;
  for (auto _ : state) {
    filter.run(report);
    benchmark::DoNotOptimize(report.log_likelihood);
  }
  state.SetItemsProcessed(state.iterations() * N * T);
}

template <class S>
void BM_BootstrapLinear(benchmark::State& state) {
  run_filter<BootstrapGuide<S>, Linear>(state);
}
template <class S>
void BM_AdaptedLinear(benchmark::State& state) {
  run_filter<AdaptedGuide<S>, Linear>(state);
}
template <class S>
void BM_TwistedLinear(benchmark::State& state) {
  run_filter<TwistedGuide<S>, Linear>(state);
}
template <class S>
void BM_BootstrapToy(benchmark::State& state) {
  run_filter<BootstrapGuide<S>, Toy>(state);
}
template <class S>
void BM_AdaptedToy(benchmark::State& state) {
  run_filter<AdaptedGuide<S>, Toy>(state);
}
template <class S>
void BM_TwistedToy(benchmark::State& state) {
  run_filter<TwistedGuide<S>, Toy>(state);
}
// in N and in T
void scaling(benchmark::internal::Benchmark* bench) {
  bench->ArgNames({"N", "T"});
  for (const int N : {50, 200, 800, 3200}) bench->Args({N, 250});
  bench->Args({200, 1000});
}
void one_size(benchmark::internal::Benchmark* bench) {
  bench->ArgNames({"N", "T"})->Args({200, 250});
}
BENCHMARK_TEMPLATE(BM_BootstrapLinear, PackD)->Apply(one_size);
BENCHMARK_TEMPLATE(BM_AdaptedLinear, PackD)->Apply(scaling);
BENCHMARK_TEMPLATE(BM_AdaptedLinear, PackF)->Apply(one_size);
BENCHMARK_TEMPLATE(BM_TwistedLinear, PackD)->Apply(scaling);
BENCHMARK_TEMPLATE(BM_TwistedLinear, PackF)->Apply(one_size);
BENCHMARK_TEMPLATE(BM_BootstrapToy, PackD)->Apply(one_size);
BENCHMARK_TEMPLATE(BM_AdaptedToy, PackD)->Apply(scaling);
BENCHMARK_TEMPLATE(BM_AdaptedToy, PackF)->Apply(one_size);
BENCHMARK_TEMPLATE(BM_TwistedToy, PackD)->Apply(one_size);

/// EKF, RTS and the functions psi: what the twisted filter needs first. Counts steps.
void BM_GaussianSmoother(benchmark::State& state) {
  constexpr int T = 250;
  Linear scene(T);
  GaussianPath path;
  for (auto _ : state) gaussian_smoother(scene.model, scene.y, path);
  state.SetItemsProcessed(state.iterations() * T);
}
void BM_MakeTwist(benchmark::State& state) {
  constexpr int T = 250;
  Linear scene(T);
  GaussianPath path;
  Twist twist;
  gaussian_smoother(scene.model, scene.y, path);
  for (auto _ : state) make_twist(scene.model, scene.y, path, twist);
  state.SetItemsProcessed(state.iterations() * T);
}
BENCHMARK(BM_GaussianSmoother);
BENCHMARK(BM_MakeTwist);

/// The exact backward kernel at n = 18: one path against N particles. Counts pairs. Budget 5 ns.
template <class S>
void BM_BackwardPair(benchmark::State& state) {
  constexpr int n = 18;
  const int N = static_cast<int>(state.range(0));
  const LinearModel model = six_joints();
  Rng rng(1, 0);
  Slice<S> slice{Cloud<S>(n, N), Cloud<S>(n, N),
                 std::vector<double>(static_cast<std::size_t>(padded(N)), 0.0),
                 std::vector<int>(static_cast<std::size_t>(padded(N)), 0)};
  std::vector<double> x(n);
  for (int i = 0; i < n; ++i) {
    x[static_cast<std::size_t>(i)] = 0.1 * rng.normal();
    for (int p = 0; p < N; ++p) slice.image.set(p, i, static_cast<Real<S>>(0.1 * rng.normal()));
  }
  BackwardKernel<S> kernel(model.Q(), N);
  kernel.prepare(slice);
  double ess, u = 0.37;
  for (auto _ : state) {
    kernel.aim(x);
    benchmark::DoNotOptimize(kernel.draw(u, ess));
  }
  state.SetItemsProcessed(state.iterations() * N);
}
BENCHMARK_TEMPLATE(BM_BackwardPair, PackD)->ArgName("N")->Arg(50)->Arg(200)->Arg(3200);
BENCHMARK_TEMPLATE(BM_BackwardPair, PackF)->ArgName("N")->Arg(200);

/// Eight smoothed paths of a toy run; counts path-steps. Method: 0 exact, 1 moves, 2 trace.
void BM_SmoothedPaths(benchmark::State& state) {
  constexpr int N = 200, T = 250, M = 8;
  Toy scene(T);
  AdaptedGuide<PackD> guide(scene.model, scene.y);
  FilterOptions options;
  options.particles = N;
  ParticleFilter filter(scene.model, guide, options);
  auto history = History<PackD>::full(3, N, T);
  Report report;
  filter.run(report, &history);
  BackwardOptions backward;
  backward.method = static_cast<Backward>(state.range(0));
  BackwardWorkspace<PackD> ws(scene.model.Q(), N, M, backward.moves);
  std::vector<RowMatrix> paths(M);
  for (auto _ : state) sample_paths(filter, history, backward, ws, paths, report);
  state.SetItemsProcessed(state.iterations() * M * T);
}
BENCHMARK(BM_SmoothedPaths)->ArgName("method")->Arg(0)->Arg(1)->Arg(2);

}  // namespace
}  // namespace fricid::smc
