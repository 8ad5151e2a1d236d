// Writes starting inputs of the fuzz targets into the folders argv[1]/TARGET.
#include <fmt/format.h>

#include <filesystem>
#include <fstream>
#include <string>

#include "blank_evaluation.hpp"
#include "fricid/base/files.hpp"
#include "fricid/data/artefact.hpp"
#include "fricid/data/fit_file.hpp"
#include "fricid/data/model_file.hpp"
#include "fricid/scene/problem.hpp"
#include "fricid/sim/excitation_file.hpp"
#include "fricid/workflow/manifest.hpp"
#include "good_signals.hpp"
#include "log_samples.hpp"
#include "source_dir.hpp"
#include "two_link_arm.hpp"

namespace fricid {
namespace {

namespace fs = std::filesystem;

fs::path corpus;

void write(const char* target, const std::string& name, const std::string& bytes) {
  fs::create_directories(corpus / target);
  std::ofstream(corpus / target / name, std::ios::binary) << bytes;
}

void write_logs() {
  int count = 0;
  for (const data::LogSample& sample : data::log_samples(4)) {
    const bool german = sample.format == "german_csv";
    const char format = sample.format == "rsi_xml"      ? 2
                        : sample.format == "kuka_trace" ? 3
                        : sample.format == "mat"        ? 4
                        : sample.format == "mcap"       ? 5
                                                        : static_cast<char>(german ? 1 : 0);
    std::string content = sample.files[0].second;
    if (format == 3) content += sample.files[1].second;
    write("log", fmt::format("{}_{}", sample.format, count), format + content);
    write("contract", fmt::format("{}_{}", sample.format, count++), sample.contract);
  }
}

void write_scenes_and_robots() {
  for (const auto& entry : fs::recursive_directory_iterator(source_dir()))
    if (entry.path().extension() == ".toml" &&
        entry.path().string().find("/build/") == std::string::npos)
      write(entry.path().stem().string().ends_with("contract") ? "contract" : "scene",
            entry.path().filename().string(), read_file(entry.path()));
  for (const auto& entry : fs::recursive_directory_iterator(source_dir() / "models"))
    if (entry.path().extension() == ".urdf")
      write("urdf", entry.path().filename().string(), read_file(entry.path()));
  write("scene", "two_link.toml", std::string(kScene));
  write("urdf", "two_link.urdf", kArmUrdf);
}

/// A model of two joints for each law and modifier.
void write_models() {
  data::ModelFile model{.name = "model", .label = "Model", .arm = {}};
  model.arm.robot = dynamics::parse_urdf(kArmUrdf, "arm", Eigen::Matrix3d::Identity());
  const auto save = [&](const std::string& name, friction::RobotFriction friction) {
    model.arm.friction.theta.clear();
    for (const friction::ParameterRef& p : friction.parameters())
      model.arm.friction.theta.push_back(std::clamp(1.0, p.info.lower, p.info.upper));
    model.arm.friction.model = std::move(friction);
    const fs::path file = corpus / "model" / name;
    fs::create_directories(file.parent_path());
    data::save_model(model, file);
  };
  for (const friction::LawInfo& law : friction::law_table())
    if (!friction::is_learned(law.name)) {
      const friction::LawSpec spec{std::string(law.name), law.has_elements ? 2 : 0, {}};
      save(std::string(law.name), friction::RobotFriction({{{spec}}, {{spec}}}));
    }
  for (const friction::LawInfo& modifier : friction::modifier_table()) {
    const friction::LawSpec spec{"lugre", 0, {{std::string(modifier.name), 1}}};
    save(std::string(modifier.name), friction::RobotFriction({{{spec}}, {}}));
  }
}

void write_artefacts() {
  evaluate::Evaluation evaluation = blank_evaluation("scene", {0.1, 1}, {"validation_0"});
  add_model(evaluation, "oracle", true, {1e-6, 1e-5});
  add_model(evaluation, "simple", false, {1e-4, 1e-3});
  write("artefact", "evaluation", '\0' + data::to_json(evaluation));
  data::FitFile fit;
  fit.name = fit.label = "simple";
  fit.joints.resize(2);
  fit.multi_step.emplace();
  fit.em.emplace();
  fit.candidates.resize(1);
  fit.parts.resize(1);
  fit.faults.resize(1);
  for (data::FittedJoint& joint : fit.joints) joint.joint = "shoulder";
  write("artefact", "fit", '\1' + data::to_json(fit));
  workflow::Manifest manifest;
  manifest.sources = {{"robot.urdf", "hash"}};
  manifest.at("identify simple_s1").outputs = {{"models/simple_s1.json", "hash"}};
  write("artefact", "manifest", '\2' + data::to_json(manifest));
  sim::ExcitationFile excitation;
  excitation.trajectories.resize(1);
  excitation.trajectories[0].joints.resize(2);
  write("artefact", "excitation", '\3' + data::to_json(excitation));
}

/// A file of each kind behind its header, and changes of it, for the reader of that number.
void write_signals() {
  const fs::path file = corpus / "signals.h5";
  char reader = 0;
  for (const std::string& good : fuzz::good_files(file)) {
    write("hdf5", fmt::format("file_{}", int{reader}),
          std::string{'\0', reader} + good.substr(512));
    write("hdf5", fmt::format("changes_{}", int{reader}),
          std::string{'\1', reader} + std::string(62, '\1'));
    ++reader;
  }
  fs::remove(file);
}

}  // namespace
}  // namespace fricid

int main(int argc, char** argv) {
  if (argc != 2) return 2;
  fricid::corpus = argv[1];
  fricid::write_logs();
  fricid::write_scenes_and_robots();
  fricid::write_models();
  fricid::write_artefacts();
  fricid::write_signals();
}
