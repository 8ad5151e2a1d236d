#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "fricid/system/arm.hpp"
#include "fricid/system/noise.hpp"

namespace fricid::data {

/// An identified robot: all that a program needs to simulate it.
struct ModelFile {
  std::string name;   ///< e.g. "lugre"
  std::string label;  ///< for tables and plots, e.g. "LuGre"
  int seed = 1;
  Arm arm;
  std::optional<LatentNoise> noise = {};  ///< noise model for filters; none unless fitted
  int free_parameters = 0;                ///< number of fitted values
  std::string budget = {};  ///< what the fit spent, for tables, e.g. "1000 steps (windows)"
  bool is_oracle = false;
  std::vector<std::string> doubts = {};  ///< why not to trust it, one sentence each
};

/// JSON, format "fricid.model/1": robot tree and parameters in full precision (round trip to the
/// last bit), friction law by law with named parameters. Written atomically.
void save_model(const ModelFile& model, const std::filesystem::path& path);
/// @throws UserError naming the file and the key when something is missing or out of bounds
ModelFile load_model(const std::filesystem::path& path);

/// The text of a model file.
std::string model_text(const ModelFile& model);
/// @param where  the file, for messages
/// @throws UserError as load_model does
ModelFile parse_model(std::string_view text, const std::string& where);

}  // namespace fricid::data
