#include "fricid/deploy/export.hpp"

#include <algorithm>
#include <array>

#include "fricid/base/error.hpp"
#include "fricid/base/files.hpp"
#include "fricid/deploy/c_header.hpp"
#include "writers.hpp"

namespace fricid::deploy {
namespace {

Exported write_c(const data::ModelFile& model) {
  Exported exported{.files = {{code_name(model) + "_friction.h", c_header(model)}}, .losses = {}};
  if (model.arm.robot.coupled())
    exported.losses.push_back("q, v and torques are those of the motors: " +
                              motors_in_words(model.arm.robot));
  return exported;
}

struct Row {
  Format format;
  Exported (*write)(const data::ModelFile&);
  bool couples = false;  ///< can represent coupled motors, or leaves them to its user
};
constexpr std::array kRows = {
    Row{{"c", "C99 header of the friction, torque and states"}, write_c, true},
    Row{{"csv", "table of steady friction torque over speed"}, write_csv, true},
    Row{{"urdf", "identified rigid body"}, write_urdf},
    Row{{"mjcf", "identified rigid body for MuJoCo"}, write_mjcf, true},
};
std::string_view name_of(const Row& row) { return row.format.name; }
constexpr auto kFormats = [] {
  std::array<Format, kRows.size()> formats;
  for (std::size_t i = 0; i < kRows.size(); ++i) formats[i] = kRows[i].format;
  return formats;
}();

}  // namespace

std::span<const Format> formats() { return kFormats; }

std::string format_list() {
  std::string list;
  for (const Row& row : kRows)
    list += fmt::format("{}{}", list.empty() ? "" : ", ", row.format.name);
  return list;
}

void require_format(std::string_view format) {
  if (std::ranges::find(kRows, format, &name_of) == kRows.end())
    throw UserError("unknown format '{}'; allowed: {}", format, format_list());
}

Exported export_model(const data::ModelFile& model, std::string_view format) {
  require_format(format);
  const Row& row = *std::ranges::find(kRows, format, &name_of);
  if (model.arm.robot.coupled() && !row.couples)
    throw UserError("{}: {} cannot represent that {}; allowed: mjcf, c, csv", model.name, format,
                    motors_in_words(model.arm.robot));
  return row.write(model);
}

void save(const Exported& exported, const std::filesystem::path& folder) {
  for (const TextFile& file : exported.files) write_file_atomically(folder / file.name, file.text);
}

}  // namespace fricid::deploy
