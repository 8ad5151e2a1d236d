// Parameters of friction laws and modifiers as keys of a file, from the tables of fricid::friction.
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "fricid/friction/robot_friction.hpp"

namespace fricid::data {

/// One key: a parameter, or a family k1, k2, ... of one value per element under the key "k".
struct FrictionKey {
  std::string key;
  std::vector<int> members;  ///< indices into the parameters; one per element of a family
  bool family = false;
};

/// A law or a modifier with its parameters for a number of elements.
struct FrictionOwner {
  std::string name;
  std::vector<friction::ParameterInfo> parameters;
  std::vector<FrictionKey> keys;
};

/// @param elements  number of elements of a law, number of terms of a modifier
FrictionOwner law_owner(const friction::LawInfo& row, int elements);
FrictionOwner modifier_owner(const friction::LawInfo& row, int elements);

/// The row of a table by name; null when unknown.
const friction::LawInfo* find_row(std::span<const friction::LawInfo> rows, std::string_view name);
/// "none, coulomb_viscous, ..."
std::string list_names(std::span<const friction::LawInfo> rows);

/// " N m", or nothing without a unit.
std::string unit_suffix(const friction::ParameterInfo& info);
/// "0.0001 to 10000 N m"
std::string list_bounds(const friction::ParameterInfo& info);

}  // namespace fricid::data
