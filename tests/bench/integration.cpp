// Prints the table of docs/integration.md: how far each way of stepping an arm over a 4 ms sample
// strays from the exact solution and from the simulator's, at each horizon, and what it costs.
//
//     build/release/tests/bench/fricid_integration
#include <fmt/format.h>

#include <ctime>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "kr6_truth.hpp"

namespace {

using namespace fricid;
using namespace fricid::test;

constexpr int kLanes = PackD::kLanes;
constexpr int kTrajectories = 8;
constexpr int kSamples = 7854;
constexpr int kFineSteps = 256;  // 1/64 ms
constexpr std::array<int, 4> kHorizons{25, 250, 2500, kSamples - 1};
constexpr std::array<int, 5> kStarts{0, 1000, 2300, 3700, 5300};

/// State of all lanes.
struct State {
  std::vector<PackD> q, v, z;
};

/// Right-hand side and friction step of an arm.
class System {
 public:
  explicit System(const Arm& arm) : arm_(arm), ws_(arm.robot), tau_f_(n()), net_(n()), in_(n()) {
    for (const double value : arm.robot.pi) pi_.push_back(PackD(value));
    for (const double value : arm.friction.theta) theta_.push_back(PackD(value));
  }
  std::size_t n() const { return static_cast<std::size_t>(arm_.robot.n()); }
  std::vector<PackD> tau;

  void acceleration(const std::vector<PackD>& q, const std::vector<PackD>& v,
                    const std::vector<PackD>& z, std::vector<PackD>& a) {
    torque(q, v, z);
    for (std::size_t j = 0; j < n(); ++j) net_[j] = tau[j] - tau_f_[j];
    dynamics::forward_dynamics<PackD>(arm_.robot, ws_, pi_, q, v, net_, a);
  }
  void step_friction(const std::vector<PackD>& q, const std::vector<PackD>& v, double h,
                     std::vector<PackD>& z) {
    set_inputs(q, v);
    arm_.friction.model.step<PackD>(theta_, in_, h, z);
  }

 private:
  void set_inputs(const std::vector<PackD>& q, const std::vector<PackD>& v) {
    for (std::size_t j = 0; j < n(); ++j) in_[j] = {q[j], v[j], tau[j], kRoomTemperature};
  }
  void torque(const std::vector<PackD>& q, const std::vector<PackD>& v,
              const std::vector<PackD>& z) {
    set_inputs(q, v);
    arm_.friction.model.torque<PackD>(theta_, in_, z, tau_f_);
  }

  const Arm& arm_;
  dynamics::Workspace<PackD> ws_;
  std::vector<PackD> pi_, theta_, tau_f_, net_;
  std::vector<friction::Input<PackD>> in_;
};

void add(std::vector<PackD>& x, double h, const std::vector<PackD>& dx) {
  for (std::size_t j = 0; j < x.size(); ++j) x[j] += PackD(h) * dx[j];
}

/// One step of length h; `work` keeps vectors between calls.
struct Work {
  std::vector<PackD> a, b, q, v, z;
};
using Step = std::function<void(System&, double h, State&, Work&)>;

// Explicit midpoint on (q, v), z exact with the mean velocity of each part.      2 evaluations
void midpoint(System& system, double h, State& x, Work& w) {
  system.acceleration(x.q, x.v, x.z, w.a);
  w.q = x.q, w.v = x.v, w.z = x.z;
  add(w.q, h / 2, x.v);
  add(w.v, h / 4, w.a);
  system.step_friction(w.q, w.v, h / 2, w.z);
  add(w.v, h / 4, w.a);
  system.acceleration(w.q, w.v, w.z, w.a);
  add(x.v, h, w.a);
  add(x.q, h, w.v);
  system.step_friction(x.q, w.v, h, x.z);
}

// Half a drift of (q, z), kick with what depends on v at the old velocity, half a drift. 1
// evaluation
void lagging(System& system, double h, State& x, Work& w) {
  add(x.q, h / 2, x.v);
  system.step_friction(x.q, x.v, h / 2, x.z);
  system.acceleration(x.q, x.v, x.z, w.a);
  add(x.v, h, w.a);
  add(x.q, h / 2, x.v);
  system.step_friction(x.q, x.v, h / 2, x.z);
}

// The same, the kick at the middle velocity.                                     2 evaluations
void splitting(System& system, double h, State& x, Work& w) {
  add(x.q, h / 2, x.v);
  system.step_friction(x.q, x.v, h / 2, x.z);
  system.acceleration(x.q, x.v, x.z, w.a);
  w.v = x.v;
  add(w.v, h / 2, w.a);
  system.acceleration(x.q, w.v, x.z, w.a);
  add(x.v, h, w.a);
  add(x.q, h / 2, x.v);
  system.step_friction(x.q, x.v, h / 2, x.z);
}

// Velocity Verlet: half a kick, drift, half a kick.                              2 evaluations
void verlet(System& system, double h, State& x, Work& w) {
  system.acceleration(x.q, x.v, x.z, w.a);
  add(x.v, h / 2, w.a);
  add(x.q, h, x.v);
  system.step_friction(x.q, x.v, h, x.z);
  system.acceleration(x.q, x.v, x.z, w.a);
  add(x.v, h / 2, w.a);
}

// Heun on (q, v), z exact with the mean velocity.                                2 evaluations
void heun(System& system, double h, State& x, Work& w) {
  system.acceleration(x.q, x.v, x.z, w.a);
  w.q = x.q, w.v = x.v, w.z = x.z;
  add(w.q, h, x.v);
  add(w.v, h / 2, w.a);
  system.step_friction(w.q, w.v, h, w.z);
  add(w.v, h / 2, w.a);
  system.acceleration(w.q, w.v, w.z, w.b);
  add(x.q, h, x.v);
  add(x.q, h * h / 2, w.a);
  for (std::size_t j = 0; j < x.v.size(); ++j) {
    w.v[j] = x.v[j] + PackD(h / 4) * (w.a[j] + w.b[j]);
    x.v[j] += PackD(h / 2) * (w.a[j] + w.b[j]);
  }
  system.step_friction(x.q, w.v, h, x.z);
}

/// Advances a state over one sample under a held torque.
using Advance = std::function<void(const std::vector<PackD>& tau, State&)>;

Advance by_steps(const Arm& arm, const Step& step, int substeps) {
  auto system = std::make_shared<System>(arm);
  auto work = std::make_shared<Work>();
  work->a.resize(system->n());
  work->b.resize(system->n());
  return [=](const std::vector<PackD>& tau, State& x) {
    system->tau = tau;
    for (int s = 0; s < substeps; ++s) step(*system, kSamplePeriod / substeps, x, *work);
  };
}

Advance by_library(const Arm& arm, StepOptions options) {
  auto stepper = std::make_shared<ArmStepper<PackD>>(arm, options);
  const std::vector<PackD> temperature(static_cast<std::size_t>(arm.robot.n()), kRoomTemperature);
  return [=](const std::vector<PackD>& tau, State& x) {
    stepper->step(tau, temperature, kSamplePeriod, x.q, x.v, x.z);
  };
}

/// Positions of all rollouts, (steps + 1) n packs each, and the processor time they took.
struct Rollouts {
  std::vector<std::vector<PackD>> q;
  double seconds = 0;
};

class Benchmark {
 public:
  explicit Benchmark(const Arm& arm) {
    for (int i = 0; i < kTrajectories; ++i)
      recordings_.push_back(
          record(arm, HangingMotion(static_cast<std::uint64_t>(i + 1)), kSamples, {8}));
  }

  Rollouts roll_out(const Advance& advance) const {
    Rollouts out;
    const std::clock_t begin = std::clock();
    for (int group = 0; group < kTrajectories / kLanes; ++group)
      for (const int start : kStarts) {
        const int steps = start == 0 ? kSamples - 1 : kHorizons[2];
        State x{load(&Recording::q, group, start), load(&Recording::v, group, start),
                load(&Recording::z, group, start)};
        auto& q = out.q.emplace_back(x.q);
        for (int k = 0; k < steps; ++k) {
          advance(load(&Recording::tau, group, start + k), x);
          q.insert(q.end(), x.q.begin(), x.q.end());
        }
      }
    out.seconds = static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC;
    return out;
  }

 private:
  std::vector<PackD> load(RowMatrix Recording::*signal, int group, int k) const {
    std::vector<PackD> packs(static_cast<std::size_t>((recordings_[0].*signal).cols()));
    for (std::size_t j = 0; j < packs.size(); ++j)
      for (int l = 0; l < kLanes; ++l)
        set_lane(packs[j], l,
                 (recordings_[static_cast<std::size_t>(group * kLanes + l)].*signal)(
                     k, static_cast<Eigen::Index>(j)));
    return packs;
  }

  std::vector<Recording> recordings_;
};

/// Geometric mean over rollouts of the mean squared difference of q up to a horizon.
double difference(const Rollouts& a, const Rollouts& b, int steps) {
  double logs = 0;
  int count = 0;
  for (std::size_t r = 0; r < a.q.size(); ++r) {
    const std::size_t values = static_cast<std::size_t>(steps + 1) * 6;
    if (a.q[r].size() < values) continue;
    PackD sum(0);
    for (std::size_t i = 0; i < values; ++i) {
      const PackD e = a.q[r][i] - b.q[r][i];
      sum += e * e;
    }
    for (int l = 0; l < kLanes; ++l) {
      logs += std::log(sum[l] / static_cast<double>(values));
      ++count;
    }
  }
  return std::exp(logs / count);
}

void print_table(const char* law) {
  const Arm arm{hanging_kr6(), kr6_friction(law)};
  const Benchmark benchmark(arm);
  const Rollouts exact = benchmark.roll_out(by_steps(arm, splitting, kFineSteps));
  const Rollouts simulator = benchmark.roll_out(by_library(arm, {8, 1}));
  double samples = 0;
  for (const int start : kStarts) samples += start == 0 ? kSamples - 1 : kHorizons[2];
  fmt::print(
      "\n## {}\n\n| scheme | steps per sample | us per sample | exact: 0.1 s | 1 s | 10 s | 31.4 s "
      "| "
      "simulator: 0.1 s | 1 s | 10 s | 31.4 s |\n"
      "|---|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|\n",
      law);
  const auto row = [&](const std::string& name, int steps_per_sample, const Advance& advance) {
    const Rollouts rollouts = benchmark.roll_out(advance);
    fmt::print("| {} | {} | {:.1f} |", name, steps_per_sample,
               1e6 * rollouts.seconds / samples / kTrajectories);
    for (const Rollouts* reference : {&exact, &simulator})
      for (const int steps : kHorizons)
        fmt::print(" {:.1e} |", difference(rollouts, *reference, steps));
    fmt::print("\n");
    std::fflush(stdout);
  };

  for (const int m : {1, 2, 4, 8, 16}) row("semi-implicit Euler", m, by_library(arm, {m, 1}));
  const std::array<std::pair<const char*, Step>, 5> schemes{{{"explicit midpoint", midpoint},
                                                             {"Heun", heun},
                                                             {"velocity Verlet", verlet},
                                                             {"splitting, velocity lags", lagging},
                                                             {"symmetric splitting", splitting}}};
  for (const auto& [name, step] : schemes)
    for (const int m : {1, 2, 4}) row(name, m, by_steps(arm, step, m));
  row("symmetric splitting", 128, by_steps(arm, splitting, 128));
  for (const int leap : {8, 4, 2})
    row(fmt::format("leap of {} Euler steps", leap), 8 / leap, by_library(arm, {8, leap}));
}

}  // namespace

int main(int argc, char** argv) {
  const std::vector<const char*> laws =
      argc > 1 ? std::vector<const char*>(argv + 1, argv + argc)
               : std::vector<const char*>{"lugre", "gms", "maxwell_slip"};
  for (const char* law : laws) print_table(law);
}
