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
  Exported exported{.files = {{code_name(model) + "_friction.h", c_header(model)}},
                    .losses = torques_left_out(model.arm.robot, false)};
  if (model.arm.robot.coupled()) exported.losses.push_back(coordinates_in_words(model.arm.robot));
  return exported;
}

// A writer that measures nothing.
template <Exported (*write)(const data::ModelFile&)>
Exported exact(const data::ModelFile& model, const Motion* /*held_out*/) {
  return write(model);
}

struct Row {
  Format format;
  Exported (*write)(const data::ModelFile&, const Motion*);
  bool couples = false;  ///< can represent coupled motors, or leaves them to its user
};
constexpr std::array kRows = {
    Row{{"c", "C99 header of the friction, torque and states"}, exact<write_c>, true},
    Row{{"csv", "table of steady friction torque over speed"}, exact<write_csv>, true},
    Row{{"urdf", "identified rigid body"}, exact<write_urdf>},
    Row{{"mjcf", "identified rigid body for MuJoCo"}, exact<write_mjcf>, true},
    Row{{"mjcf_friction", "rigid body and friction as elements of MJCF"},
        write_mjcf_friction,
        true},
    Row{{"plugin", "rigid body and friction for the MuJoCo plugin"}, exact<write_plugin>, true},
    Row{{"fmu", "friction as an FMU, FMI 3.0 co-simulation"}, exact<write_fmu>, true},
    Row{{"onnx", "friction as ONNX, its state an input and an output"}, exact<write_onnx>, true},
};
std::string_view name_of(const Row& row) { return row.format.name; }
constexpr auto kFormats = [] {
  std::array<Format, kRows.size()> formats;
  for (std::size_t i = 0; i < kRows.size(); ++i) formats[i] = kRows[i].format;
  return formats;
}();

// Names of the formats with a property: "c, csv, ...".
template <class Property>
std::string list_of(Property has) {
  std::string list;
  for (const Row& row : kRows)
    if (has(row)) list += fmt::format("{}{}", list.empty() ? "" : ", ", row.format.name);
  return list;
}

}  // namespace

std::span<const Format> formats() { return kFormats; }

std::string format_list() {
  return list_of([](const Row&) { return true; });
}

void require_format(std::string_view format) {
  if (std::ranges::find(kRows, format, &name_of) == kRows.end())
    throw UserError("unknown format '{}'; allowed: {}", format, format_list());
}

Exported export_model(const data::ModelFile& model, std::string_view format,
                      const Motion* held_out) {
  require_format(format);
  const Row& row = *std::ranges::find(kRows, format, &name_of);
  if (model.arm.robot.coupled() && !row.couples)
    throw UserError("{}: {} cannot represent that {}; allowed: {}", model.name, format,
                    motors_in_words(model.arm.robot),
                    list_of([](const Row& r) { return r.couples; }));
  Exported exported = row.write(model, held_out);
  if (!model.doubts.empty()) exported.losses.insert(exported.losses.begin(), doubt_in_words(model));
  return exported;
}

void save(const Exported& exported, const std::filesystem::path& folder) {
  for (const TextFile& file : exported.files) write_file_atomically(folder / file.name, file.text);
}

}  // namespace fricid::deploy
