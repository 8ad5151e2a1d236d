// The [friction] section: laws and modifiers by the tables of fricid::friction.
#pragma once

#include <toml++/toml.h>

#include <string>
#include <vector>

#include "fricid/friction/robot_friction.hpp"

namespace fricid::scene {

/// A law on some joints, as one [[friction.law]] says it.
struct LawEntry {
  friction::LawSpec spec;
  std::vector<int> joints;
  std::vector<std::vector<double>> values;  ///< per joint: law, then its modifiers
};

/// Reads [friction]. Each [[friction.law]] adds one law to its joints, in file order; its modifiers
/// apply in the order of the modifier table, the first innermost.
/// @throws UserError "file:line: ..." on an unknown law, key or joint, and on a parameter that is
///         missing or out of bounds
friction::Friction read_friction(const toml::table& table, const std::string& where,
                                 const std::vector<std::string>& joint_names);

/// The same friction as text that `read_friction` reads back to the last bit.
std::string write_friction(const friction::Friction& friction,
                           const std::vector<std::string>& joint_names);

/// One commented [[friction.law]] per law of the table, with the typical values, then the
/// modifiers.
std::string friction_template();

}  // namespace fricid::scene
