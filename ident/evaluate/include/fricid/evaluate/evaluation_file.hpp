// evaluation.json of a run folder, as everybody reads it.
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>

namespace fricid::evaluate {

/// The evaluation of a run folder, format fricid.evaluation/1. Names of scene, models and
/// trajectories in it are what names.hpp allows, and labels show: names may become paths.
/// @throws UserError naming the file when it is missing, no evaluation, or has other names
nlohmann::json load_evaluation(const std::filesystem::path& folder);

}  // namespace fricid::evaluate
