// Rigid-body dynamics of the KR6 per state: items are states. Budget on one AVX-512 core at 3.7
// GHz: forward dynamics 52 ns in f64, one 25th of mj_forward.
#include <benchmark/benchmark.h>

#include <filesystem>
#include <vector>

#include "fricid/base/rng.hpp"
#include "fricid/dynamics/algorithms.hpp"
#include "source_dir.hpp"

namespace fricid::dynamics {
namespace {

/// A robot and a ring of random states, a different one in every lane.
template <class S>
struct Case {
  static constexpr size_t kRing = 16;

  RobotModel model = load_urdf(source_dir() / "models/kr6_r700/kr6_r700.urdf");
  Workspace<S> ws{model};
  std::vector<S> pi;
  std::vector<std::vector<S>> q, v, a;

  Case() {
    for (const double x : model.pi) pi.push_back(S(x));
    Rng rng(1, 0);
    for (auto* ring : {&q, &v, &a}) {
      ring->assign(kRing, std::vector<S>(model.joints.size()));
      for (auto& state : *ring)
        for (S& x : state)
          for (int l = 0; l < kLaneCount<S>; ++l)
            set_lane(x, l, static_cast<decltype(lane(x, 0))>(rng.normal()));
    }
  }
};

template <class S, class Call>
void run(benchmark::State& state, Call call) {
  Case<S> c;
  std::vector<S> out(c.model.joints.size());
  size_t k = 0;
  for (auto _ : state) {
    call(c, k, out);
    benchmark::DoNotOptimize(out.data());
    benchmark::ClobberMemory();
    k = (k + 1) % Case<S>::kRing;
  }
  state.SetItemsProcessed(state.iterations() * kLaneCount<S>);
}

template <class S>
void BM_ForwardDynamics(benchmark::State& state) {
  run<S>(state, [](Case<S>& c, size_t k, std::vector<S>& out) {
    forward_dynamics<S>(c.model, c.ws, c.pi, c.q[k], c.v[k], c.a[k], out);
  });
}

template <class S>
void BM_Rnea(benchmark::State& state) {
  run<S>(state, [](Case<S>& c, size_t k, std::vector<S>& out) {
    rnea<S>(c.model, c.ws, c.pi, c.q[k], c.v[k], c.a[k], out);
  });
}

template <class S>
void BM_RneaPullback(benchmark::State& state) {
  run<S>(state,
         [v_bar = std::vector<S>(6, S(0)), a_bar = std::vector<S>(6, S(0)),
          pi_bar = std::vector<S>(66, S(0))](Case<S>& c, size_t k, std::vector<S>& out) mutable {
           rnea_pullback<S>(c.model, c.ws, c.pi, c.q[k], c.v[k], c.a[k], c.a[k], out, v_bar, a_bar,
                            pi_bar);
         });
}

BENCHMARK(BM_ForwardDynamics<PackD>)->Name("BM_ForwardDynamics/f64");
BENCHMARK(BM_ForwardDynamics<PackF>)->Name("BM_ForwardDynamics/f32");
BENCHMARK(BM_ForwardDynamics<double>)->Name("BM_ForwardDynamics/scalar");
BENCHMARK(BM_Rnea<PackD>)->Name("BM_Rnea/f64");
BENCHMARK(BM_Rnea<PackF>)->Name("BM_Rnea/f32");
BENCHMARK(BM_RneaPullback<PackD>)->Name("BM_RneaPullback/f64");
BENCHMARK(BM_RneaPullback<PackF>)->Name("BM_RneaPullback/f32");

}  // namespace
}  // namespace fricid::dynamics
