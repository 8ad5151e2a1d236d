// What was injected, apart from the data sets: another struct, another file. No estimator links
// this library, so none can read it.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "fricid/friction/robot_friction.hpp"
#include "fricid/sim/trace.hpp"

namespace fricid::sim {

/// The truth of one sequence. At every sample  M(q) a + h(q, v) + tau_f = tau.
struct Truth {
  std::string name;                      ///< of its data set, e.g. "train_0"
  std::vector<std::string> joint_names;  ///< (n)
  double rate_hz = 0;
  Trace trace;
  friction::Friction friction;

  double dt() const { return 1 / rate_hz; }
};

/// HDF5, format "fricid.truth/1": /t /q /v /a /tau (applied) /tau_f /z /temperature with attribute
/// `unit`; root attributes joint_names, rate_hz and friction, which is JSON:
/// {"joints": [{"laws": [{"law", "elements", "modifiers": [{"name", "order"}],
///                        "parameters": [{"owner", "symbol", "value", "unit"}]}]}]}.
/// Written atomically.
void save_truth(const Truth& truth, const std::filesystem::path& path);
/// @throws UserError naming the file when it is missing, a folder, torn or of another format
Truth load_truth(const std::filesystem::path& path);

}  // namespace fricid::sim
