// Friction as graphs of operations.
#pragma once

#include <vector>

#include "fricid/friction/robot_friction.hpp"
#include "symbol.hpp"

namespace fricid::deploy {

/// Graph of a friction; outputs are its nodes.
struct Traced {
  Graph torque;
  std::vector<int> tau_f;  ///< (n)
  Graph step;
  std::vector<int> z_next;  ///< (state_size)
};

/// Torque and step of a friction of n joints as graphs, for all laws and modifiers.
Traced trace(const friction::RobotFriction& friction);

/// The parameters for such graphs, which have weights that do not act too (LvmPaper without
/// cross): theta with those at zero.
std::vector<double> traced_theta(const friction::Friction& friction);

}  // namespace fricid::deploy
