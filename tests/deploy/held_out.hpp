// Held-out motion of a scene.
#pragma once

#include <string>

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

}  // namespace fricid::deploy::test
