// The simulator on one core: MuJoCo alone, and the whole true arm with the friction of kr6_full.
#include <benchmark/benchmark.h>

#include <vector>

#include "fricid/scene/problem.hpp"
#include "fricid/sim/plant.hpp"
#include "fricid/sim/simulate.hpp"
#include "source_dir.hpp"

namespace fricid::sim {
namespace {

struct Scene {
  scene::Problem problem = scene::load_problem(source_dir() / "scenes/kr6_full.toml");
  MujocoArm arm = make_arm(problem);

  static const Scene& once() {
    static const Scene scene;
    return scene;
  }
};

const std::vector<double> kHanging{0.2, -1.5, 0.3, 0.1, -0.4, 0.2};

MjDataPtr moving_state(const MujocoArm& arm) {
  MjDataPtr data = arm.make_data();
  for (int j = 0; j < arm.n(); ++j) {
    data->qpos[arm.qpos(j)] = kHanging[static_cast<std::size_t>(j)];
    data->qvel[arm.dof(j)] = 0.5;
  }
  return data;
}

void BM_MjForward(benchmark::State& state) {
  const MujocoArm& arm = Scene::once().arm;
  const MjDataPtr data = moving_state(arm);
  for (auto _ : state) {
    mj_forward(&arm.model(), data.get());
    benchmark::DoNotOptimize(data->qacc);
  }
  state.SetItemsProcessed(state.iterations());  // states
}
BENCHMARK(BM_MjForward);

void BM_MjStep(benchmark::State& state) {
  const MujocoArm& arm = Scene::once().arm;
  const MjDataPtr start = moving_state(arm), data = arm.make_data();
  constexpr int kSteps = 1000;
  for (auto _ : state) {
    mj_copyData(data.get(), &arm.model(), start.get());
    for (int k = 0; k < kSteps; ++k) mj_step(&arm.model(), data.get());
    benchmark::DoNotOptimize(data->qpos);
  }
  state.SetItemsProcessed(state.iterations() * kSteps);  // physics steps
}
BENCHMARK(BM_MjStep);

// One second of the true arm. real_time_factor: simulated seconds per second, at least 20.
void BM_Plant(benchmark::State& state) {
  const Scene& scene = Scene::once();
  Plant plant(scene.arm, scene.problem.robot, *scene.problem.scene.friction);
  const int samples = static_cast<int>(scene.problem.scene.sensors.rate_hz);
  const int steps = steps_per_sample(1.0 / samples, scene.arm.step());
  const State start{kHanging, std::vector<double>(6, 0.5),
                    std::vector<double>(static_cast<std::size_t>(plant.state_size()), 0.0)};
  const std::vector<double> tau{20, 30, 10, 4, 3, 2}, temperature(6, 293.15);
  for (auto _ : state) {
    plant.set_state(start);
    for (int k = 0; k < samples; ++k) plant.hold(tau, temperature, steps);
    benchmark::DoNotOptimize(plant.state());
  }
  state.SetItemsProcessed(state.iterations() * samples * steps);  // physics steps
  state.counters["real_time_factor"] =
      benchmark::Counter(static_cast<double>(state.iterations()), benchmark::Counter::kIsRate);
}
BENCHMARK(BM_Plant);

}  // namespace
}  // namespace fricid::sim
