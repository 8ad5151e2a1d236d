// Short simulated logs without damage, for the tests of the doctor.
#pragma once

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "doctor/injected.hpp"
#include "fricid/base/parallel.hpp"
#include "fricid/doctor/doctor.hpp"
#include "fricid/scene/problem.hpp"
#include "fricid/sim/simulate.hpp"
#include "source_dir.hpp"

namespace fricid::doctor {

struct Log {
  data::Dataset data;
  dynamics::RobotModel robot;
};

/// Two short logs of a scene, with velocity and temperature.
inline std::vector<Log> simulate_logs(const std::string& scene, std::uint64_t seed) {
  scene::Scene e = scene::load_scene(source_dir() / "scenes" / (scene + ".toml"));
  e.seed = seed;
  e.plant.step_s = kSimulatorStep;
  e.excitation.train = e.excitation.repeats = e.excitation.validation = 1;
  e.excitation.criterion = sim::Criterion::kNone;
  e.excitation.harmonics = 5;
  e.excitation.base_rad_s = 0.6;
  e.sensors.velocity = e.sensors.temperature = true;
  const scene::Problem problem = scene::resolve(std::move(e));
  const sim::Simulation s = sim::simulate(problem, 1);
  return {{s.train[0], problem.robot}, {s.validation[0], problem.robot}};
}

/// Clean logs, made once.
inline const std::vector<Log>& clean_logs() {
  static const std::vector<Log> logs = [] {
    const std::vector<std::pair<const char*, std::uint64_t>> scenes{
        {"kr6_full", 1},    {"kr6_lugre", 2},     {"kr6_gms", 3},   {"kr6_load", 4},
        {"kr6_thermal", 5}, {"kr6_stickslip", 6}, {"kr6_floor", 7}, {"kr6_strong", 8},
        {"kr6_full", 9},    {"kr6_gms", 10}};
    std::vector<std::vector<Log>> pairs(scenes.size());
    parallel_for(static_cast<int>(scenes.size()), 0, [&](int i) {
      const auto& [scene, seed] = scenes[static_cast<std::size_t>(i)];
      pairs[static_cast<std::size_t>(i)] = simulate_logs(scene, seed);
    });
    std::vector<Log> all;
    for (const auto& pair : pairs) all.insert(all.end(), pair.begin(), pair.end());
    return all;
  }();
  return logs;
}

inline std::string text_of(const std::vector<Finding>& findings, const data::Dataset& d) {
  std::string text;
  for (const Finding& f : findings)
    if (is_damage(f)) text += to_text(f, d) + "\n";
  return text;
}

inline std::vector<Finding> of_kind(const std::vector<Finding>& findings, const std::string& name) {
  std::vector<Finding> found;
  for (const Finding& f : findings)
    if (name_of(f.kind) == name) found.push_back(f);
  return found;
}

}  // namespace fricid::doctor
