// Graphs of operations as C.
#pragma once

#include <set>
#include <string>
#include <vector>

#include "symbol.hpp"

namespace fricid::deploy {

/// Names of the leaves of a graph in C.
struct LeafNames {
  std::string prefix;                   ///< of the macros and helpers of the header
  std::vector<std::string> parameters;  ///< symbols of theta, for comments and local names
  bool whole_robot = false;             ///< inputs are arrays over the joints
};

/// The body of a function and what it uses.
struct CBody {
  std::string statements;                   ///< locals, one a line
  std::vector<std::string> outputs;         ///< expressions
  std::set<Op> helpers;                     ///< operations that are helper functions
  std::set<Field> fields;                   ///< inputs that are read
  bool parameters = false, states = false;  ///< whether theta, z are read
  bool loops = false;                       ///< needs a loop variable `int i`
};

CBody write_body(const Graph& graph, const std::vector<int>& outputs, const LeafNames& names);

/// Definitions of the helpers that the operations need.
std::string c_helpers(const std::set<Op>& operations, const std::string& prefix);

/// A number as a C constant of the header's type: PREFIX_R(0.1).
std::string c_number(double value, const std::string& prefix);

inline constexpr const char* kFieldNames[] = {"q", "v", "load", "temperature"};

}  // namespace fricid::deploy
