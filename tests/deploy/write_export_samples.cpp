// Writes what the table of exports is made from: for every law and modifier the exports that other
// programs load, the torque of the engine along a motion, and the errors of the header.
//
//     write_export_samples FOLDER
//
// motion: (steps, joints, 4) q, v, load, temperature; NAME.tau: (steps, joints) the torque after
// each step; both doubles. laws.json: the errors of the headers, and the losses of mjcf_friction.
#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <nlohmann/json.hpp>

#include "fricid/base/error.hpp"
#include "fricid/deploy/export.hpp"
#include "law_errors.hpp"

namespace {

bool has_gap(const fricid::data::ModelFile& model) {
  const auto& parameters = model.arm.friction.model.parameters();
  return std::ranges::any_of(parameters, [](const auto& p) { return p.owner == "backlash"; });
}

}  // namespace

int main(int argc, char** argv) {
  using namespace fricid;
  using namespace fricid::deploy::test;
  if (argc != 2) {
    std::cerr << "write_export_samples FOLDER\n";
    return 2;
  }
  const std::filesystem::path folder = argv[1];
  const auto models = all_robots();
  const std::string compiler = c_compilers().front();
  const auto as_double = header_errors(models, compiler, "", folder / "c");
  const auto as_float = header_errors(models, compiler, "-DFRICID_FLOAT", folder / "c");
  write_binary(folder / "motion", motion());
  nlohmann::ordered_json laws;
  for (std::size_t i = 0; i < models.size(); ++i) {
    const data::ModelFile& model = models[i];
    nlohmann::ordered_json law{{"name", model.name},
                               {"parameters", model.arm.friction.model.parameter_count()},
                               {"states", model.arm.friction.model.state_size()},
                               {"has_gap", has_gap(model)},
                               {"joints", nlohmann::ordered_json::array()},
                               {"c", as_double[i]},
                               {"c_float", as_float[i]}};
    for (const dynamics::Joint& joint : model.arm.robot.joints) law["joints"].push_back(joint.name);
    for (const char* format : {"fmu", "onnx", "plugin", "mjcf_friction"}) try {
        const deploy::Exported exported = deploy::export_model(model, format);
        for (const deploy::TextFile& file : exported.files)
          write_binary(folder / format / file.name, file.text);
        law[format] = exported.losses;
      } catch (const UserError& error) {
        law[format] = error.what();
      }
    write_binary(folder / (model.name + ".tau"), torques_after_steps(model));
    laws.push_back(law);
  }
  write_binary(folder / "laws.json", laws.dump(1));
}
