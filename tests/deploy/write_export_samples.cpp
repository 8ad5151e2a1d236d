// Writes what the table of exports is made from: for every law and modifier the exports that other
// programs load, the torque of the engine along a motion, and the errors of the header.
//
//     write_export_samples FOLDER
//
// and the same for the truth of two scenes along their held-out motion. NAME.motion: (steps,
// joints, 4) q, v, load, temperature; NAME.tau: (steps, joints) the torque after each step; both
// doubles. laws.json: dt, the errors of the headers and of the plugin as shares of the largest
// torque, and the losses of mjcf_friction.
#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <nlohmann/json.hpp>

#include "fricid/base/error.hpp"
#include "fricid/deploy/export.hpp"
#include "held_out.hpp"
#include "law_errors.hpp"
#include "plugin_errors.hpp"

namespace {

using namespace fricid;
using namespace fricid::deploy::test;

using Inputs = std::vector<friction::Input<double>>;

/// Writes the exports of a model, its motion and its torques. Returns its entry of laws.json.
nlohmann::ordered_json written(const data::ModelFile& model, const Inputs& motion, double dt,
                               const std::filesystem::path& folder) {
  nlohmann::ordered_json law{{"name", model.name},
                             {"parameters", model.arm.friction.model.parameter_count()},
                             {"states", model.arm.friction.model.state_size()},
                             {"dt", dt},
                             {"joints", nlohmann::ordered_json::array()}};
  for (const dynamics::Joint& joint : model.arm.robot.joints) law["joints"].push_back(joint.name);
  for (const char* format : {"fmu", "onnx", "plugin", "urdf", "mjcf", "mjcf_friction"}) try {
      const deploy::Exported exported = deploy::export_model(model, format);
      for (const deploy::TextFile& file : exported.files)
        write_binary(folder / format / file.name, file.text);
      law[format] = exported.losses;
    } catch (const UserError& error) {
      law[format] = error.what();
    }
  write_binary(folder / "model" / (model.name + ".json"), data::model_text(model));
  write_binary(folder / (model.name + ".motion"), motion);
  write_binary(folder / (model.name + ".tau"), torques_after_steps(model, motion, dt));
  return law;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) {
    std::cerr << "write_export_samples FOLDER\n";
    return 2;
  }
  const std::filesystem::path folder = argv[1];
  const auto models = all_robots();
  const std::string compiler = c_compilers().front();
  const auto as_double = header_errors(models, motion(), kDt, compiler, "", folder / "c");
  const auto as_float =
      header_errors(models, motion(), kDt, compiler, "-DFRICID_FLOAT", folder / "c");
  nlohmann::ordered_json laws;
  for (std::size_t i = 0; i < models.size(); ++i) {
    laws.push_back(written(models[i], motion(), kDt, folder));
    laws.back()["c"] = as_double[i];
    laws.back()["c_float"] = as_float[i];
    const PluginErrors errors = plugin_errors(models[i]);
    laws.back()["plugin_error"] = errors.worst / std::max(errors.largest, 1e-300);
  }
  for (const char* name : {"kr6_demo", "kr6_stickslip"}) {
    const HeldOut held = held_out(name);
    laws.push_back(written(held.model, inputs_of(held.truth.trace), held.truth.dt(), folder));
  }
  write_binary(folder / "laws.json", laws.dump(1));
}
