// `fricid info`, `fricid template`, `fricid --version`.
#include <fmt/format.h>

#include "commands.hpp"
#include "fricid/base/error.hpp"
#include "fricid/base/files.hpp"
#include "fricid/base/json.hpp"
#include "fricid/base/names.hpp"
#include "fricid/base/unit_of_joint.hpp"
#include "fricid/config/paths.hpp"
#include "fricid/data/contract.hpp"
#include "fricid/data/hdf5.hpp"
#include "fricid/data/model_file.hpp"
#include "fricid/data/written_model.hpp"
#include "fricid/film/gl_context.hpp"
#include "fricid/scene/problem.hpp"
#include "fricid/sim/mujoco_arm.hpp"
#include "fricid/workflow/version.hpp"
#include "terminal.hpp"

namespace fricid::cli {
namespace {

void print_hdf5(const std::filesystem::path& path, bool csv, bool json) {
  const std::string format = data::hdf5_format(path);
  const data::H5Reader file(path, format);
  if (csv) return data::print_tables(file, [](const std::string& line) { print(line); });
  nlohmann::json tables;
  for (const std::string& name : file.names()) {
    const data::TableShape shape = file.shape(name);
    tables[name] = {{"rows", shape.rows}, {"columns", shape.columns}, {"unit", file.unit(name)}};
  }
  const nlohmann::json summary{
      {"format", format}, {"joints", file.joint_names()}, {"tables", tables}};
  if (json) return print_json(summary);
  print(fmt::format("{}: {}\njoints: {}\n", printable(path.string()), printable(format),
                    fmt::join(file.joint_names(), " ")));
  for (const auto& [name, table] : tables.items())
    print(fmt::format("  {:<14}{:>8} x {:<4}{}\n", printable(name),
                      table["rows"].get<std::int64_t>(), table["columns"].get<std::int64_t>(),
                      printable(table["unit"].get<std::string>())));
}

void print_model(const std::filesystem::path& path) {
  const data::ModelFile model = data::load_model(path);
  const Arm& arm = model.arm;
  print(fmt::format("{}: model {} ({}), seed {}, {} fitted values\n", printable(path.string()),
                    model.name, model.label, model.seed, model.free_parameters));
  const auto& parameters = arm.friction.model.parameters();
  for (std::size_t i = 0; i < parameters.size(); ++i) {
    const int at = parameters[i].joint;
    const dynamics::Joint* joint =
        at == friction::kWholeRobot ? nullptr : &arm.robot.joints[static_cast<std::size_t>(at)];
    print(fmt::format("  {:<12}{:<18}{:<10}{:>12.6g} {}\n", joint ? joint->name : "whole robot",
                      parameters[i].owner, parameters[i].symbol, arm.friction.theta[i],
                      unit_of_joint(parameters[i].info.unit, joint && slides(*joint))));
  }
}

}  // namespace

Verdict info(const InfoOptions& options, const CommonOptions& common) {
  const std::filesystem::path& file = options.file;
  if (file.extension() == ".toml") {
    print(scene::to_toml(scene::load_problem(file).scene));
  } else if (file.extension() == ".json") {
    const auto content = parse_json(read_file(file), file.string());
    if (!common.json && content.is_object() &&
        content.value("format", nlohmann::json()) == data::WrittenModel::kFormat)
      print_model(file);
    else
      print_json(content);
  } else {
    print_hdf5(file, options.csv, common.json);
  }
  return Verdict::kDone;
}

Verdict print_template(const std::string& topic) {
  if (topic == "scene")
    print(scene::scene_template());
  else if (topic == "contract")
    print(data::contract_template());
  else
    print(read_file(config::share_dir() / "models/template.urdf"));
  return Verdict::kDone;
}

void print_version() {
#if defined(__AVX512F__)
  constexpr std::string_view simd = "AVX-512";
#elif defined(__AVX2__)
  constexpr std::string_view simd = "AVX2";
#else
  constexpr std::string_view simd = "SSE2";
#endif
  print(fmt::format("fricid {} ({})\nMuJoCo {}\nSIMD {}, {} doubles per pack\n", kVersion, kCommit,
                    mj_versionString(), simd, PackD::kLanes));
  for (const std::string& line : film::describe_gl_backends()) print("renderer " + line + "\n");
}

}  // namespace fricid::cli
