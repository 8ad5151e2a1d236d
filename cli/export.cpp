// fricid export: models in the formats of other tools.
#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <set>

#include "commands.hpp"
#include "fricid/base/error.hpp"
#include "fricid/config/paths.hpp"
#include "fricid/data/artefact.hpp"
#include "fricid/data/dataset.hpp"
#include "fricid/data/model_file.hpp"
#include "fricid/deploy/export.hpp"
#include "fricid/sim/mjcf.hpp"
#include "fricid/workflow/manifest.hpp"
#include "fricid/workflow/run.hpp"
#include "fricid/workflow/run_folder.hpp"
#include "terminal.hpp"

namespace fricid::cli {
namespace {

namespace fs = std::filesystem;

// The run that a target is, or that a model lies in.
std::optional<workflow::RunFolder> run_of(const fs::path& target) {
  if (fs::is_directory(target)) return workflow::RunFolder(target);
  if (target.parent_path().filename() != "models") return {};
  return workflow::RunFolder(target.parent_path().parent_path());
}

// The manifest of a run; none where the folder is none of a run, or of an earlier version.
std::optional<workflow::Manifest> manifest_of(const std::optional<workflow::RunFolder>& run) {
  if (!run || !workflow::is_run_folder(run->path())) return {};
  try {
    return data::load<workflow::Manifest>(run->manifest());
  } catch (const UserError&) {
    return {};
  }
}

// A model file, or those of a run folder without the truth's. Of models of former data a line is
// printed, and those of a folder are left out.
std::vector<data::ModelFile> models_of(const fs::path& target) {
  const std::optional<workflow::RunFolder> run = run_of(target);
  const std::optional<workflow::Manifest> manifest = manifest_of(run);
  const auto is_outdated = [&](const fs::path& file, std::string_view consequence) {
    const std::string why = manifest ? workflow::outdated(*run, *manifest, file) : std::string();
    if (!why.empty()) print(fmt::format("{}: {}{}\n", file.string(), consequence, why), stderr);
    return !why.empty();
  };
  if (!fs::is_directory(target)) {
    is_outdated(target, "");
    return {data::load_model(target)};
  }
  std::vector<data::ModelFile> models;
  bool any_outdated = false;
  if (fs::is_directory(run->models()))
    for (const fs::path& file : run->files_in(run->models(), ".json")) {
      data::ModelFile model = data::load_model(file);
      if (model.is_oracle) continue;
      if (is_outdated(file, "left out: "))
        any_outdated = true;
      else
        models.push_back(std::move(model));
    }
  if (models.empty() && any_outdated)
    throw UserError("{}: all models are of other data; run `fricid identify` again",
                    run->models().string());
  if (models.empty())
    throw UserError("{}: found no models; run `fricid identify` first", run->models().string());
  return models;
}

// The first held-out recording of the run.
std::optional<data::Dataset> held_out(const std::optional<workflow::RunFolder>& run) {
  if (!run) return {};
  const fs::path recording = run->recording(workflow::RunFolder::validation(0));
  if (!fs::exists(recording)) return {};
  return data::load_dataset(recording);
}

}  // namespace

Verdict export_models(const ExportOptions& options, const CommonOptions& common) {
  deploy::Exported all;
  std::set<std::string> names;
  // make all exports before writing the first
  deploy::require_format(options.format);
  const bool extends = !options.mjcf.empty();
  if (extends && options.format != "plugin")
    throw UserError("--mjcf: found with {}; allowed: with plugin", options.format);
  const std::optional<data::Dataset> log = held_out(run_of(options.target));
  for (const data::ModelFile& model : models_of(options.target)) {
    std::optional<deploy::Motion> motion;
    if (extends) sim::require_joints(options.mjcf, model.arm.robot);
    if (log && log->n() == model.arm.robot.n()) motion = deploy::motion_of(*log, model.arm.robot);
    deploy::Exported one = deploy::export_model(model, options.format, motion ? &*motion : nullptr);
    if (extends) one.files.pop_back();  // the rigid body
    for (deploy::TextFile& file : one.files) {
      if (!names.insert(file.name).second)
        throw UserError(
            "{}: two models make the file {}; allowed: names that differ in letters "
            "and digits",
            options.target.string(), file.name);
      all.files.push_back(std::move(file));
    }
    for (std::string& loss : one.losses)
      if (std::ranges::find(all.losses, loss) == all.losses.end())
        all.losses.push_back(std::move(loss));
    for (std::string& note : one.notes)
      if (std::ranges::find(all.notes, note) == all.notes.end())
        all.notes.push_back(std::move(note));
  }
  if (fs::exists(options.output) && !fs::is_directory(options.output))
    throw UserError("{}: found a file; allowed: a folder", options.output.string());
  deploy::save(all, options.output);

  if (common.json) {
    nlohmann::json result = {
        {"files", nlohmann::json::array()}, {"losses", all.losses}, {"notes", all.notes}};
    for (const deploy::TextFile& file : all.files)
      result["files"].push_back((options.output / file.name).string());
    print_json(result);
    return Verdict::kDone;
  }
  for (const deploy::TextFile& file : all.files)
    print((options.output / file.name).string() + "\n");
  for (const std::string& loss : all.losses) print("note: " + loss + "\n");
  for (const std::string& note : all.notes) print("note: " + note + "\n");
  if (extends)
    for (const deploy::TextFile& file : all.files)
      print("note: add <include file=\"" + file.name + "\"/> to " + options.mjcf.string() + "\n");
  if (options.format == "plugin")
    print("note: load " + config::mujoco_plugin().string() + " before the model\n");
  return Verdict::kDone;
}

}  // namespace fricid::cli
