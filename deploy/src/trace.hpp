// Friction as graphs of operations.
#pragma once

#include <vector>

#include "fricid/friction/robot_friction.hpp"
#include "symbol.hpp"

namespace fricid::deploy {

/// What a friction computes: outputs are nodes of the graph.
struct Traced {
  Graph torque;
  std::vector<int> tau_f;  ///< (n)
  Graph step;
  std::vector<int> z_next;  ///< (state_size)
};

/// torque and step of a friction of n joints on symbols: whatever its laws and modifiers are.
Traced trace(const friction::RobotFriction& friction);

}  // namespace fricid::deploy
