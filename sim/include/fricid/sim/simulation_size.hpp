#pragma once

#include "fricid/scene/problem.hpp"

namespace fricid::sim {

/// Sizes of what `simulate` makes of a scene.
struct SimulationSize {
  double recordings = 0, training = 0;  ///< all of them; those to train on
  double samples = 0;                   ///< of each
  double bytes = 0;                     ///< that all of them take at once
};
SimulationSize size_of_simulation(const scene::Problem& problem);

/// Asked before a simulation. @throws UserError naming the scene when that is too much (limits.hpp)
void require_memory_of_simulation(const scene::Problem& problem);

}  // namespace fricid::sim
