// Held-out motion of a scene.
#pragma once

#include <string>
#include <vector>

#include "fricid/data/model_file.hpp"
#include "fricid/scene/problem.hpp"
#include "fricid/sim/simulate.hpp"
#include "source_dir.hpp"

namespace fricid::deploy::test {

/// The true arm of a scene as a model, and its held-out motion.
struct HeldOut {
  data::ModelFile model;
  sim::Truth truth;
  double physics_step;
};
inline HeldOut held_out(const char* name) {
  scene::Scene scene = scene::load_scene(source_dir() / "scenes" / (std::string(name) + ".toml"));
  scene.excitation.train = 1;
  scene.excitation.repeats = 1;
  scene.excitation.validation = 1;
  scene.excitation.criterion = sim::Criterion::kNone;
  const scene::Problem problem = scene::resolve(std::move(scene));
  HeldOut result;
  result.model.name = result.model.label = name;
  result.model.arm = {problem.robot, *problem.scene.friction};
  result.truth = sim::simulate(problem, 1).validation_truth.front();
  result.physics_step = problem.scene.plant.step_s;
  return result;
}

/// Position, velocity, load and temperature of the joints at each sample, joint by joint.
inline std::vector<friction::Input<double>> inputs_of(const sim::Trace& trace) {
  std::vector<friction::Input<double>> inputs;
  for (Eigen::Index k = 0; k < trace.q.rows(); ++k)
    for (Eigen::Index j = 0; j < trace.q.cols(); ++j)
      inputs.push_back({trace.q(k, j), trace.v(k, j), trace.tau(k, j), trace.temperature(k, j)});
  return inputs;
}

}  // namespace fricid::deploy::test
