// Elementary functions of base: time per element, `items_per_second` counts elements.
#include <benchmark/benchmark.h>

#include <cstdint>
#include <vector>

#include "fricid/base/math.hpp"
#include "fricid/base/rng.hpp"

namespace fricid {
namespace {

constexpr int kElements = 1024;

/// kElements arguments spread over [low, high].
template <class S>
std::vector<S> arguments(double low, double high) {
  std::vector<S> x(kElements / kLaneCount<S>, S(0));
  Rng rng(1, 0);
  for (S& pack : x) {
    for (int i = 0; i < kLaneCount<S>; ++i) {
      using T = decltype(lane(pack, 0));
      set_lane(pack, i, static_cast<T>(low + (high - low) * rng.uniform()));
    }
  }
  return x;
}

/// Applies `function` to every element, over and over.
template <class S, class Function>
void run(benchmark::State& state, Function function, double low, double high) {
  const std::vector<S> x = arguments<S>(low, high);
  std::vector<S> y(x.size(), S(0));
  for (auto _ : state) {
    for (std::size_t i = 0; i < x.size(); ++i) y[i] = function(x[i]);
    benchmark::DoNotOptimize(y.data());
    benchmark::ClobberMemory();
  }
  state.SetItemsProcessed(state.iterations() * kElements);
}

/// Registers BM_<name>/f64, /f32 (packs) and /scalar (double).
template <class Function>
void register_all(const char* name, Function function, double low, double high) {
  const std::string prefix = std::string("BM_") + name;
  benchmark::RegisterBenchmark((prefix + "/f64").c_str(), [=](benchmark::State& state) {
    run<PackD>(state, function, low, high);
  });
  benchmark::RegisterBenchmark((prefix + "/f32").c_str(), [=](benchmark::State& state) {
    run<PackF>(state, function, low, high);
  });
  benchmark::RegisterBenchmark((prefix + "/scalar").c_str(), [=](benchmark::State& state) {
    run<double>(state, function, low, high);
  });
}

/// Random numbers in bulk and one by one.
template <class Fill>
void fill_buffer(benchmark::State& state, Fill fill) {
  std::vector<double> out(kElements);
  std::uint64_t first = 0;
  for (auto _ : state) {
    fill(first, out);
    first += kElements;
    benchmark::DoNotOptimize(out.data());
    benchmark::ClobberMemory();
  }
  state.SetItemsProcessed(state.iterations() * kElements);
}
void BM_FillUniform(benchmark::State& state) {
  fill_buffer(
      state, [](std::uint64_t first, std::vector<double>& out) { fill_uniform(1, 2, first, out); });
}
void BM_FillNormal(benchmark::State& state) {
  fill_buffer(state,
              [](std::uint64_t first, std::vector<double>& out) { fill_normal(1, 2, first, out); });
}
void BM_RngNormal(benchmark::State& state) {
  fill_buffer(state, [](std::uint64_t first, std::vector<double>& out) {
    Rng rng(1, 2, first);
    for (double& x : out) x = rng.normal();
  });
}
BENCHMARK(BM_FillUniform);
BENCHMARK(BM_FillNormal);
BENCHMARK(BM_RngNormal);

const bool registered = [] {
  register_all(
      "Exp", [](auto x) { return exp(x); }, -20, 5);
  register_all(
      "Decay", [](auto x) { return decay(x); }, 0, 20);
  register_all(
      "Expm1", [](auto x) { return expm1(x); }, -5, 5);
  register_all(
      "Log", [](auto x) { return log(x); }, 1e-3, 1e3);
  register_all(
      "Log1p", [](auto x) { return log1p(x); }, -0.9, 10);
  register_all(
      "SinCos",
      [](auto x) {
        const auto y = sincos(x);
        return y.sin + y.cos;
      },
      -10, 10);
  register_all(
      "Tanh", [](auto x) { return tanh(x); }, -4, 4);
  register_all(
      "Softplus", [](auto x) { return softplus(x); }, -10, 10);
  register_all(
      "Mish", [](auto x) { return mish(x); }, -10, 10);
  register_all(
      "Phi1", [](auto x) { return phi1(x); }, -5, 0);
  register_all(
      "Pow", [](auto x) { return pow(x, decltype(x)(0.8)); }, 0, 3);
  register_all(
      "Sqrt", [](auto x) { return sqrt(x); }, 0, 3);
  return true;
}();

}  // namespace
}  // namespace fricid
