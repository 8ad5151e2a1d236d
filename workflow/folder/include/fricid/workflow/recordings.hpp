// Reads files of a run folder if they exist and are visible to the stage.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <type_traits>
#include <vector>

#include "fricid/data/dataset.hpp"
#include "fricid/workflow/run_folder.hpp"

namespace fricid::workflow {

/// Whether a path of a run folder is that of an existing, visible file.
bool is_there(const std::filesystem::path& file);

/// The result of load(file); empty if the file does not exist.
template <class Load>
auto if_there(const std::filesystem::path& file, Load load)
    -> std::optional<std::remove_cvref_t<decltype(load(file))>> {
  if (!is_there(file)) return std::nullopt;
  return load(file);
}

/// The recordings of a run folder in order: RunFolder::training or ::validation.
/// @param joints  that every recording must have; empty: any
/// @throws UserError for a recording of other joints
std::vector<data::Dataset> load_recordings(const RunFolder& folder, std::string (*name)(int),
                                           const std::vector<std::string>& joints = {});

/// The first `seconds` of recordings one after the other; 0: all of them.
/// @throws UserError naming the recordings when so little is left that it has no two samples
std::vector<data::Dataset> first_seconds(std::vector<data::Dataset> recordings, double seconds);

}  // namespace fricid::workflow
