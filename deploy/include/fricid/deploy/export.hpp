// Models in the formats of other tools.
#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "fricid/data/model_file.hpp"
#include "fricid/signals/dataset.hpp"

namespace fricid::deploy {

/// A file of an export, named relative to its folder.
struct TextFile {
  std::string name;
  std::string text;  ///< or bytes
};

/// A motion along which the error of an approximation is measured.
struct Motion {
  std::string name;                     ///< for messages
  double dt = 0;                        ///< [s]
  RowMatrix q, v, load;                 ///< (T, n) of the motors [rad], [rad/s], [N m]
  RowMatrix temperature = RowMatrix();  ///< (T, n) [K], or empty for room temperature
};

/// The motion of a log up to its first missing value, in coordinates of the motors of `robot`.
/// Velocities that were not measured are central differences.
Motion motion_of(const signals::Dataset& log, const dynamics::RobotModel& robot);

/// An export: its files, and one sentence for each property of the model that the format lacks.
struct Exported {
  std::vector<TextFile> files;
  std::vector<std::string> losses;
  std::vector<std::string> notes{};  ///< what is to be done where the files are used
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

/// @param held_out  where an approximation is measured; null: reversals, rests and sliding
/// @throws UserError when the format is unknown, naming the known ones, or cannot represent the
/// model
Exported export_model(const data::ModelFile& model, std::string_view format,
                      const Motion* held_out = nullptr);

/// Writes the files into a folder, which is created; each file atomically.
/// @throws UserError when a file cannot be written
void save(const Exported& exported, const std::filesystem::path& folder);

}  // namespace fricid::deploy
