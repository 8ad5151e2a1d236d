// Models in the formats of other tools.
#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "fricid/data/model_file.hpp"

namespace fricid::deploy {

/// A file of an export, named relative to its folder.
struct TextFile {
  std::string name;
  std::string text;
};

/// An export: its files, and one sentence for each property of the model that the format lacks.
struct Exported {
  std::vector<TextFile> files;
  std::vector<std::string> losses;
};

/// A format of `fricid export`.
struct Format {
  std::string_view name;
  std::string_view what;  ///< one phrase
};

/// Every format that export_model knows.
std::span<const Format> formats();

/// Their names: "c, csv, ...".
std::string format_list();

/// @throws UserError when the format is unknown, naming the known ones
void require_format(std::string_view format);

/// @throws UserError when the format is unknown, naming the known ones, or cannot represent the
/// model
Exported export_model(const data::ModelFile& model, std::string_view format);

/// Writes the files into a folder, which is created; each file atomically.
/// @throws UserError when a file cannot be written
void save(const Exported& exported, const std::filesystem::path& folder);

}  // namespace fricid::deploy
