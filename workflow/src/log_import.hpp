// Logs of a scene as data sets.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "fricid/data/dataset.hpp"
#include "fricid/scene/problem.hpp"
#include "fricid/workflow/inputs.hpp"

namespace fricid::workflow {

/// Names of recordings by their place: RunFolder::training, ...
using RecordingName = std::string (*)(int);

/// Imports logs of the scene by its contract, or reads data sets where it has none; cut and with
/// the joints of its robot.
/// @param say  takes warnings
std::vector<data::Dataset> import_logs(const scene::Problem& part,
                                       const std::vector<std::string>& logs, RecordingName name,
                                       const std::function<void(const std::string&)>& say);

/// Declares the contract of the scene, if it has one.
void declare_contract(Inputs& inputs, const scene::Problem& problem);
/// Declares the content of logs.
void declare_logs(Inputs& inputs, const scene::Problem& problem,
                  const std::vector<std::string>& logs, RecordingName name);

}  // namespace fricid::workflow
