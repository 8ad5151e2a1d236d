// Cost of rolling a KR6 out by one sample of 4 ms, per state: items are lanes times samples.
#include <benchmark/benchmark.h>

#include <string>

#include "kr6_truth.hpp"

namespace {

using namespace fricid;
using namespace fricid::test;

constexpr int kSamples = 250;

// Every lane repeats the first second of its own recording of the same law.
void roll_out(benchmark::State& state, const std::string& law, StepOptions options) {
  const Arm arm{hanging_kr6(), kr6_friction(law)};
  std::vector<Recording> recordings;
  for (int l = 0; l < PackD::kLanes; ++l)
    recordings.push_back(
        record(arm, HangingMotion(static_cast<std::uint64_t>(l + 1)), kSamples, {2}));
  const auto n = static_cast<std::size_t>(arm.robot.n());
  const std::vector<PackD> temperature(n, kRoomTemperature);
  std::vector<std::vector<PackD>> tau(kSamples, std::vector<PackD>(n));
  std::vector<PackD> q(n), v(n), z(static_cast<std::size_t>(arm.friction.model.state_size()));
  for (int l = 0; l < PackD::kLanes; ++l)
    for (std::size_t k = 0; k < kSamples; ++k)
      for (std::size_t j = 0; j < n; ++j)
        set_lane(tau[k][j], l,
                 recordings[static_cast<std::size_t>(l)].tau(static_cast<Eigen::Index>(k),
                                                             static_cast<Eigen::Index>(j)));
  ArmStepper<PackD> stepper(arm, options);
  for (auto _ : state) {
    std::fill(z.begin(), z.end(), PackD(0));
    std::fill(v.begin(), v.end(), PackD(0));
    for (int l = 0; l < PackD::kLanes; ++l)
      for (std::size_t j = 0; j < n; ++j)
        set_lane(q[j], l,
                 recordings[static_cast<std::size_t>(l)].q(0, static_cast<Eigen::Index>(j)));
    for (const std::vector<PackD>& held : tau)
      stepper.step(held, temperature, kSamplePeriod, q, v, z);
    benchmark::DoNotOptimize(q.data());
    benchmark::ClobberMemory();
  }
  state.SetItemsProcessed(state.iterations() * PackD::kLanes * kSamples);
}

const bool registered = [] {
  for (const char* law : {"coulomb_viscous", "stribeck", "dahl", "lugre", "gms", "maxwell_slip"}) {
    const std::string name = std::string("BM_Rollout/") + law;
    benchmark::RegisterBenchmark(name.c_str(), roll_out, law, StepOptions{8, 1});
    benchmark::RegisterBenchmark((name + "/leap4").c_str(), roll_out, law, StepOptions{8, 4});
    benchmark::RegisterBenchmark((name + "/leap8").c_str(), roll_out, law, StepOptions{8, 8});
  }
  return true;
}();

}  // namespace
