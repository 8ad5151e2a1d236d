// Logs of a scene as data sets.
#pragma once

#include <functional>
#include <span>
#include <string>
#include <vector>

#include "fricid/data/dataset.hpp"
#include "fricid/scene/problem.hpp"
#include "fricid/workflow/inputs.hpp"

namespace fricid::workflow {

/// A log of a scene, as it is written there, and the name of the recording that is made of it.
struct SceneLog {
  std::string log, recording;
};

/// Logs with the names of recordings by their place: RunFolder::training, ...
std::vector<SceneLog> named(const std::vector<std::string>& logs, std::string (*name)(int));
/// The logs that a scene trains on, then those that it holds out.
std::vector<SceneLog> logs_of_data(const scene::Problem& problem);

/// Imports logs of the scene by its contract, or reads data sets where it has none; cut and with
/// the joints of its robot. A file of which several logs are parts is read once.
/// @param say  takes warnings
std::vector<data::Dataset> logs_of_scene(const scene::Problem& part, std::span<const SceneLog> logs,
                                         const std::function<void(const std::string&)>& say);

/// Declares the contract of the scene, if it has one.
void declare_contract(Inputs& inputs, const scene::Problem& problem);
/// Declares the content of logs.
void declare_logs(Inputs& inputs, const scene::Problem& problem, std::span<const SceneLog> logs);

}  // namespace fricid::workflow
