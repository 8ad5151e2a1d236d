// The inference engine on a KR6 with six joints: items are particle-steps, transitions or cycles.
// Budgets on one AVX-512 core: a whole particle-step (dynamics, friction, noise, weights,
// resampling) at N = 200 at most 0.10 of BM_MjForward in f64 and 0.05 in f32.
#include <benchmark/benchmark.h>
#include <sys/resource.h>

#include <algorithm>
#include <chrono>
#include <numeric>

#include "fricid/estimate/em/em.hpp"
#include "fricid/estimate/em/latent_friction_model.hpp"
#include "fricid/estimate/em/transitions.hpp"
#include "fricid/estimate/online/online.hpp"
#include "fricid/estimate/wash_out.hpp"
#include "fricid/estimate/windows/windows.hpp"
#include "fricid/smc/guides.hpp"
#include "fricid/smc/particle_filter.hpp"
#include "kr6_truth.hpp"
#include "smc/malloc_counter.hpp"
#include "unfiltered.hpp"

namespace fricid::estimate {
namespace {

constexpr double kEncoderNoise = 4e-6;  // [rad]
constexpr StepOptions kStep{8, 8};      // one leap per sample

/// A hanging KR6 with friction, a noisy recording of it and the noise a filter assumes.
struct Subject {
  Arm arm;
  std::vector<signals::Recording> recordings;
  LatentNoise noise;
  smc::Gaussian start;

  static friction::Friction friction_of(const char* law) {
    if (!friction::is_robot_law(law)) return fricid::test::kr6_friction(law);
    friction::Friction untrained{
        friction::RobotFriction(std::vector<friction::JointSpec>(6), {.law = law, .elements = 32}),
        {}};
    untrained.theta = friction::default_theta(untrained.model);
    friction::initialise_weights(untrained.model, 1, untrained.theta);
    return untrained;
  }

  Subject(const char* law, int T) : arm{fricid::test::hanging_kr6(), friction_of(law)} {
    const auto made = fricid::test::record(arm, fricid::test::HangingMotion(1), T, {8, 8});
    recordings.push_back(
        fricid::test::unfiltered("bench", fricid::test::kSamplePeriod, made.q, made.v, made.tau));
    recordings[0].noise_sd.setConstant(kEncoderNoise);
    Rng rng(1, 0);
    for (double& q : recordings[0].log.q.reshaped()) q += kEncoderNoise * rng.normal();
    noise = initial_noise(arm, recordings, {});
    const std::vector<RowMatrix> z{made.z};
    start = initial_state(recordings[0], made.z.row(0), latent_sizes(z), noise);
  }
};

template <class S>
void BM_ParticleStep(benchmark::State& state, const char* law) {
  const Subject subject(law, 300);
  LatentFrictionModel model(subject.arm, subject.recordings[0], subject.noise, subject.start,
                            kStep);
  const smc::RowMatrix y = subject.recordings[0].log.q;
  smc::AdaptedGuide<S> guide(model, y);
  smc::FilterOptions options;
  options.particles = static_cast<int>(state.range(0));
  smc::ParticleFilter<LatentFrictionModel, smc::AdaptedGuide<S>> filter(model, guide, options);
  smc::Report report;
  for (auto _ : state) filter.run(report);
  state.SetItemsProcessed(state.iterations() * y.rows() * options.particles);
  state.counters["resampled"] = report.resampled;
}
const auto* const kPackD_lugre =
    benchmark::RegisterBenchmark("BM_ParticleStep/lugre/f64", BM_ParticleStep<PackD>, "lugre")
        -> ArgName("N") -> Arg(50) -> Arg(200) -> Arg(800) -> Arg(3200);
const auto* const kPackF_lugre =
    benchmark::RegisterBenchmark("BM_ParticleStep/lugre/f32", BM_ParticleStep<PackF>, "lugre")
        -> ArgName("N") -> Arg(200);
const auto* const kPackD_gms =
    benchmark::RegisterBenchmark("BM_ParticleStep/gms/f64", BM_ParticleStep<PackD>, "gms")
        -> ArgName("N") -> Arg(200);
const auto* const kPackF_gms =
    benchmark::RegisterBenchmark("BM_ParticleStep/gms/f32", BM_ParticleStep<PackF>, "gms")
        -> ArgName("N") -> Arg(200);
const auto* const kPackD_lvm =
    benchmark::RegisterBenchmark("BM_ParticleStep/lvm/f64", BM_ParticleStep<PackD>, "lvm")
        -> ArgName("N") -> Arg(200);
const auto* const kPackF_lvm =
    benchmark::RegisterBenchmark("BM_ParticleStep/lvm/f32", BM_ParticleStep<PackF>, "lvm")
        -> ArgName("N") -> Arg(200);

/// One Jacobian of the sample step, all rows.
void BM_Jacobian(benchmark::State& state, const char* law) {
  const Subject subject(law, 100);
  LatentFrictionModel model(subject.arm, subject.recordings[0], subject.noise, subject.start,
                            kStep);
  Eigen::VectorXd f;
  Eigen::MatrixXd A;
  for (auto _ : state) {
    model.linearise(50, subject.start.mean, f, A);
    benchmark::DoNotOptimize(A.data());
  }
  state.SetItemsProcessed(state.iterations());
}
BENCHMARK_CAPTURE(BM_Jacobian, lugre, "lugre");
BENCHMARK_CAPTURE(BM_Jacobian, gms, "gms");

/// Largest memory of the process so far [MB]: of one case when it runs alone.
double peak_megabytes() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<double>(usage.ru_maxrss) / 1024;
}

/// E-step of one recording of 1000 samples: items are samples times particles (1 for ekf).
void BM_EStep(benchmark::State& state, const char* law, EStep method) {
  const Subject subject(law, 1000);
  LatentFrictionModel model(subject.arm, subject.recordings[0], subject.noise, subject.start,
                            kStep);
  const int particles = method == EStep::kEkf ? 1 : 200;
  for (auto _ : state) {
    const EStepResult result =
        smooth(model, subject.recordings[0], 1000, {method, particles, 4, 1, 0});
    benchmark::DoNotOptimize(result.log_likelihood);
  }
  state.SetItemsProcessed(state.iterations() * 1000 * particles);
  state.counters["peak_MB"] = peak_megabytes();
}
BENCHMARK_CAPTURE(BM_EStep, lugre / ekf, "lugre", EStep::kEkf)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(BM_EStep, lugre / psi, "lugre", EStep::kPsi)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(BM_EStep, lugre / adapted, "lugre", EStep::kAdapted)
    ->Unit(benchmark::kMillisecond);

/// Gradient of the transition density: items are transitions.
void BM_MStepGradient(benchmark::State& state, const char* law) {
  const Subject subject(law, 100);
  TransitionLoss loss(subject.arm, subject.recordings, kStep);
  loss.set_parameters(
      {subject.arm.robot.pi.data(), static_cast<std::size_t>(subject.arm.robot.pi.size())},
      subject.arm.friction.theta);
  smc::RowMatrix path(100, subject.start.mean.size());
  path.rowwise() = subject.start.mean.transpose();
  const std::vector<Paths> paths{{path}};
  std::vector<Transition> some(static_cast<std::size_t>(TransitionLoss::lanes()));
  for (int k = 0; k < TransitionLoss::lanes(); ++k)
    some[static_cast<std::size_t>(k)] = {0, 0, 10 * k};
  std::vector<double> pi_bar(static_cast<std::size_t>(subject.arm.robot.pi.size()));
  std::vector<double> theta_bar(subject.arm.friction.theta.size());
  for (auto _ : state) {
    benchmark::DoNotOptimize(loss.loss(some, paths, subject.noise));
    loss.add_gradient(pi_bar, theta_bar);
  }
  state.SetItemsProcessed(state.iterations() * TransitionLoss::lanes());
}
BENCHMARK_CAPTURE(BM_MStepGradient, lugre, "lugre");
BENCHMARK_CAPTURE(BM_MStepGradient, gms, "gms");

/// Gradient of a window of 125 samples: items are samples of windows.
void BM_WindowGradient(benchmark::State& state, const char* law) {
  const Subject subject(law, 400);
  const auto z = wash_out(subject.arm, subject.recordings, 1);
  WindowRollout<PackF> rollout(subject.arm, subject.recordings, {8, 4}, 125);
  rollout.set_parameters(
      {subject.arm.robot.pi.data(), static_cast<std::size_t>(subject.arm.robot.pi.size())},
      subject.arm.friction.theta);
  std::vector<Window> windows(static_cast<std::size_t>(WindowRollout<PackF>::lanes()));
  for (int k = 0; k < std::ssize(windows); ++k) windows[static_cast<std::size_t>(k)] = {0, 10 * k};
  std::vector<double> pi_bar(static_cast<std::size_t>(subject.arm.robot.pi.size()));
  std::vector<double> theta_bar(subject.arm.friction.theta.size());
  for (auto _ : state) {
    benchmark::DoNotOptimize(rollout.loss(windows, z));
    rollout.add_gradient(pi_bar, theta_bar);
  }
  state.SetItemsProcessed(state.iterations() * std::ssize(windows) * 125);
}
BENCHMARK_CAPTURE(BM_WindowGradient, lugre, "lugre")->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(BM_WindowGradient, gms, "gms")->Unit(benchmark::kMicrosecond);

/// One 4 ms cycle of the online estimator, N = 200; its median and its 99.9 % quantile [us], and
/// the blocks that all cycles took from the heap.
void BM_OnlineCycle(benchmark::State& state, const char* law) {
  constexpr int kSamples = 1000;
  const Subject subject(law, kSamples);
  const signals::Recording& r = subject.recordings[0];
  OnlineEstimator estimator(subject.arm, subject.noise, subject.start, {.step = kStep});
  std::vector<double> us;
  us.reserve(1'000'000);
  int t = 0;
  long taken = 0;
  for (auto _ : state) {
    if (t + 1 == kSamples) {
      estimator.reset();
      t = 0;
    }
    const long before = smc::test::heap_blocks();
    const auto begin = std::chrono::steady_clock::now();
    estimator.step({r.held_tau.row(t).data(), 6}, {r.log.q.row(t + 1).data(), 6});
    const std::chrono::duration<double, std::micro> took = std::chrono::steady_clock::now() - begin;
    taken += smc::test::heap_blocks() - before;
    if (us.size() < us.capacity()) us.push_back(took.count());
    ++t;
  }
  std::sort(us.begin(), us.end());
  state.counters["p50_us"] = us[us.size() / 2];
  state.counters["heap_blocks"] = static_cast<double>(taken);
  state.counters["p99.9_us"] = us[us.size() * 999 / 1000];
  state.SetItemsProcessed(state.iterations());
}
BENCHMARK_CAPTURE(BM_OnlineCycle, lugre, "lugre")
    ->Unit(benchmark::kMicrosecond)
    ->Iterations(1'000'000);
BENCHMARK_CAPTURE(BM_OnlineCycle, lvm_paper, "lvm_paper")
    ->Unit(benchmark::kMicrosecond)
    ->Iterations(100'000);

}  // namespace
}  // namespace fricid::estimate
