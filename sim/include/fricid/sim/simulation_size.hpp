#pragma once

#include "fricid/scene/problem.hpp"

namespace fricid::sim {

/// Size of the data that `simulate` makes of a scene.
struct SimulationSize {
  double recordings = 0, training = 0;  ///< number in all; of those for training
  double samples = 0;                   ///< per recording
  double bytes = 0;                     ///< memory for all of them at once
};
SimulationSize size_of_simulation(const scene::Problem& problem);

/// To be called before a simulation. @throws UserError naming the scene when it needs too much
/// memory (limits.hpp)
void require_memory_of_simulation(const scene::Problem& problem);

}  // namespace fricid::sim
