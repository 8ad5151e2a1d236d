// `fricid info`, `fricid template`, `fricid --version`.
#include <fmt/format.h>

#include <cstdio>

#include "commands.hpp"
#include "fricid/base/error.hpp"
#include "fricid/base/files.hpp"
#include "fricid/base/json.hpp"
#include "fricid/base/names.hpp"
#include "fricid/config/paths.hpp"
#include "fricid/data/contract.hpp"
#include "fricid/data/hdf5.hpp"
#include "fricid/data/model_file.hpp"
#include "fricid/data/written_model.hpp"
#include "fricid/film/gl_context.hpp"
#include "fricid/scene/problem.hpp"
#include "fricid/sim/mujoco_arm.hpp"
#include "version.hpp"

namespace fricid::cli {
namespace {

void print(const std::string& text) { std::fputs(text.c_str(), stdout); }

void print_csv(const data::H5Reader& file) {
  std::vector<data::RowMatrix> tables;
  std::string header;
  for (const std::string& name : file.names()) {
    tables.push_back(file.matrix(name));
    const auto columns = tables.back().cols();
    for (Eigen::Index j = 0; j < columns; ++j)
      header += fmt::format("{}{}{}", header.empty() ? "" : ",", printable(name),
                            columns > 1 ? std::to_string(j + 1) : "");
  }
  print(header + "\n");
  for (Eigen::Index k = 0; !tables.empty() && k < tables[0].rows(); ++k) {
    std::string row;
    for (const data::RowMatrix& table : tables)
      for (Eigen::Index j = 0; j < table.cols(); ++j)
        row += fmt::format("{}{}", row.empty() ? "" : ",", table(k, j));
    print(row + "\n");
  }
}

void print_hdf5(const std::filesystem::path& path, bool csv, bool json) {
  const std::string format = data::hdf5_format(path);
  const data::H5Reader file(path, format);
  if (csv) return print_csv(file);
  nlohmann::json tables;
  for (const std::string& name : file.names()) {
    const data::RowMatrix table = file.matrix(name);
    tables[name] = {{"rows", table.rows()}, {"columns", table.cols()}, {"unit", file.unit(name)}};
  }
  const nlohmann::json summary{
      {"format", format}, {"joints", file.joint_names()}, {"tables", tables}};
  if (json) return print(summary.dump(2) + "\n");
  print(fmt::format("{}: {}\njoints: {}\n", printable(path.string()), printable(format),
                    fmt::join(file.joint_names(), " ")));
  for (const auto& [name, table] : tables.items())
    print(fmt::format("  {:<14}{:>8} x {:<4}{}\n", printable(name), table["rows"].get<int>(),
                      table["columns"].get<int>(), printable(table["unit"].get<std::string>())));
}

void print_model(const std::filesystem::path& path) {
  const data::ModelFile model = data::load_model(path);
  const Arm& arm = model.arm;
  print(fmt::format("{}: model {} ({}), seed {}, {} fitted values\n", printable(path.string()),
                    model.name, model.label, model.seed, model.free_parameters));
  const auto& parameters = arm.friction.model.parameters();
  for (std::size_t i = 0; i < parameters.size(); ++i)
    print(fmt::format("  {:<12}{:<18}{:<10}{:>12.6g} {}\n",
                      arm.robot.joints[static_cast<std::size_t>(parameters[i].joint)].name,
                      parameters[i].owner, parameters[i].symbol, arm.friction.theta[i],
                      parameters[i].info.unit));
}

}  // namespace

Verdict info(const std::filesystem::path& file, bool csv, const CommonOptions& common) {
  if (file.extension() == ".toml") {
    print(scene::to_toml(scene::load_problem(file).scene));
  } else if (file.extension() == ".json") {
    const auto content = parse_json(read_file(file), file.string());
    if (!common.json && content.is_object() &&
        content.value("format", nlohmann::json()) == data::WrittenModel::kFormat)
      print_model(file);
    else
      print(content.dump(2, ' ', false, nlohmann::json::error_handler_t::replace) + "\n");
  } else {
    print_hdf5(file, csv, common.json);
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
  print(fmt::format("fricid {} ({})\nMuJoCo {}\nSIMD {}, {} doubles per pack\n", kFricidVersion,
                    kFricidCommit, mj_versionString(), simd, PackD::kLanes));
  for (const std::string& line : film::describe_gl_backends()) print("renderer " + line + "\n");
}

}  // namespace fricid::cli
