#include "held_out.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <set>
#include <utility>

#include "fricid/base/error.hpp"
#include "fricid/base/names.hpp"
#include "fricid/data/log_part.hpp"
#include "fricid/signals/recording.hpp"
#include "fricid/workflow/check.hpp"
#include "fricid/workflow/recordings.hpp"

namespace fricid::workflow {

namespace fs = std::filesystem;

namespace {

/// @throws UserError when the truth is not that of the recording
void require_truth_of(const data::Dataset& data, const fs::path& data_file, const sim::Truth& truth,
                      const fs::path& truth_file) {
  if (truth.joint_names != data.joint_names)
    throw UserError("{}: found joints {}; allowed: those of {}, {}", truth_file.string(),
                    fmt::join(truth.joint_names, ", "), data_file.string(),
                    fmt::join(data.joint_names, ", "));
  if (truth.trace.t.size() != data.t.size() || truth.rate_hz != data.rate_hz)
    throw UserError("{}: found {} samples at {:g} Hz; allowed: as {}, {} at {:g} Hz",
                    truth_file.string(), truth.trace.t.size(), truth.rate_hz, data_file.string(),
                    data.t.size(), data.rate_hz);
}

std::optional<sim::Truth> truth_in(const fs::path& file) {
  if (!is_there(file)) return std::nullopt;
  return sim::load_truth(file);
}

/// @param at_joints  the recording with the joints of the robot
/// @param in_file    its joints as they stand in the file
/// @param truth      as read from `truth_file`, if there is one
void add_recording(HeldOut& held_out, data::Dataset at_joints,
                   const std::vector<std::string>& in_file, const fs::path& data_file,
                   std::optional<sim::Truth> truth, const fs::path& truth_file, double cutoff_hz) {
  evaluate::Trajectory trajectory;
  trajectory.data = std::move(at_joints);
  const signals::Recording recording = signals::make_recording(trajectory.data, cutoff_hz);
  const double of_step = 1 / std::sqrt(12.0);  // rounded
  trajectory.q_sd = recording.noise_sd.cwiseMax(of_step * recording.step);
  signals::Motion motion = recording.narrow;
  trajectory.q = std::move(motion.q);
  trajectory.v = std::move(motion.v);
  trajectory.a = std::move(motion.a);
  if (truth) {
    if (in_file != trajectory.data.joint_names)
      throw UserError("{}: found a truth of the joints {}; allowed: in the order of the robot, {}",
                      truth_file.string(), fmt::join(in_file, ", "),
                      fmt::join(trajectory.data.joint_names, ", "));
    require_truth_of(trajectory.data, data_file, *truth, truth_file);
    held_out.truths.push_back(*std::move(truth));
    const sim::Trace& trace = held_out.truths.back().trace;
    trajectory.truth = evaluate::Reference{trace.q, trace.v, trace.tau_f, trace.z};
  }
  held_out.trajectories.push_back(std::move(trajectory));
}

/// The truth of further data where the scene injects the same friction; else none, and why.
std::optional<sim::Truth> truth_of(const scene::Problem& problem, const fs::path& file,
                                   const std::function<void(const std::string&)>& say) {
  std::optional<sim::Truth> truth = truth_in(file);
  if (!truth) return truth;
  const std::optional<friction::Friction>& injected = problem.scene.friction;
  if (injected && sim::friction_text(*injected) == sim::friction_text(truth->friction))
    return truth;
  say(fmt::format(
      "{}: not used: {}", file.string(),
      injected ? "its friction is not that of the scene" : "the scene injects no friction"));
  return std::nullopt;
}

/// @throws UserError when no recording is as long as any horizon
void require_horizons(const scene::Scene& scene, const HeldOut& held_out) {
  double longest = 0;
  for (const evaluate::Trajectory& trajectory : held_out.trajectories)
    longest = std::max(longest, trajectory.data.dt() * (trajectory.data.length() - 1));
  const double shortest = std::ranges::min(scene.evaluate.horizons_s);
  if (shortest > longest * (1 + 1e-9))
    throw UserError(
        "{}: evaluate.horizons_s = {:g} s and more; allowed: one of at most {:.4g} s, the longest "
        "recording to evaluate on, or 0, all of it",
        scene.origin.place("evaluate.horizons_s"), shortest, longest);
}

/// @throws UserError when the models were fitted to samples of a recording
void refuse_training(const data::Dataset& recording, std::span<const data::Dataset> training,
                     const fs::path& file) {
  for (const data::Dataset& learnt : training)
    if (const int shared = data::samples_in_common(recording, learnt); shared > 0)
      throw UserError(
          "--data {}: {:.3g} s of it are in {}, which is trained on; allowed: other recordings",
          file.string(), shared * recording.dt(), learnt.name);
}

/// @throws UserError when all of a recording is in one that is held out already
void refuse_again(const data::Dataset& recording, std::span<const evaluate::Trajectory> held_out,
                  const fs::path& file) {
  for (const evaluate::Trajectory& known : held_out)
    if (data::samples_in_common(recording, known.data) == recording.length())
      throw UserError("--data {}: all of it is in {}; allowed: each recording once", file.string(),
                      known.data.name);
}

/// Models of which results are written, as they stand in names of files.
std::set<std::string> labels_of(const RunFolder& run, const std::vector<FitRequest>& fits) {
  std::set<std::string> labels;
  const auto add = [&](const FitId& id) { labels.insert({id.model, id.name()}); };
  for (const FitRequest& fit : fits) add(fit.id());
  for (const char* truth : {"oracle", "simulator"}) add({truth, 1});
  for (const fs::path& folder : external_folders(run, fits)) add({folder.filename(), 1});
  return labels;
}

/// The folder that a data set is from: that of its run, or the one it lies in.
std::string origin_of(const fs::path& file) {
  const fs::path folder = fs::weakly_canonical(file).parent_path();
  return (folder.filename() == "data" ? folder.parent_path() : folder).filename().string();
}

bool may_name_a_recording(const std::string& name) {
  try {
    require_name(Named::kTrajectory, name, "");
    return true;
  } catch (const UserError&) {
    return false;
  }
}

}  // namespace

fs::path truth_beside(const fs::path& dataset) {
  return RunFolder(dataset.parent_path().parent_path()).truth(dataset.stem().string());
}

std::vector<fs::path> external_folders(const RunFolder& run, const std::vector<FitRequest>& fits) {
  std::vector<fs::path> folders;
  if (!fs::exists(run.external())) return folders;
  for (const auto& entry : fs::directory_iterator(run.external())) {
    const std::string name = entry.path().filename().string(), shown = entry.path().string();
    if (name.starts_with('.')) continue;
    if (!entry.is_directory()) throw UserError("{}: a file; allowed: one folder per model", shown);
    require_name(Named::kModel, name, shown);
    if (std::ranges::any_of(fits, [&](const FitRequest& fit) { return fit.model.name == name; }))
      throw UserError("{}: a model of this run has this name", shown);
    folders.push_back(entry.path());
  }
  std::ranges::sort(folders);
  return folders;
}

std::vector<FurtherData> named_apart(const Job& job, const std::vector<FitRequest>& fits,
                                     const std::vector<fs::path>& files) {
  const RunFolder& run = job.run.folder();
  const std::set<std::string> labels = labels_of(run, fits);
  std::set<std::string> taken;  // names of results
  const auto results = [&](const std::string& recording) {
    std::vector<std::string> names;
    for (const std::string& label : labels) names.push_back(label + "_" + recording);
    return names;
  };
  const auto take = [&](const std::string& recording) {
    for (const std::string& name : results(recording)) taken.insert(name);
  };
  const auto is_free = [&](const std::string& recording) {
    return may_name_a_recording(recording) && !is_there(run.recording(recording)) &&
           std::ranges::none_of(results(recording),
                                [&](const std::string& name) { return taken.contains(name); });
  };
  for (int i = 0; is_there(run.recording(RunFolder::validation(i))); ++i)
    take(RunFolder::validation(i));
  std::vector<FurtherData> data;
  for (const fs::path& file : files) {
    const std::string stem = file.stem().string();
    std::string longer = fmt::format("{}_{}", origin_of(file), stem);
    if (!may_name_a_recording(longer + "_1000")) longer = "further";
    std::string name = is_free(stem) ? stem : longer;
    for (int i = 2; !is_free(name); ++i) name = fmt::format("{}_{}", longer, i);
    take(name);
    data.push_back({file, name});
  }
  return data;
}

HeldOut load_held_out(const scene::Problem& problem, std::span<const FurtherData> further_data,
                      const RunFolder& folder, std::span<const data::Dataset> training,
                      const std::function<void(const std::string&)>& say) {
  HeldOut held_out;
  const double cutoff = problem.scene.identify.cutoff_hz;
  for (int i = 0; is_there(folder.recording(RunFolder::validation(i))); ++i) {
    const std::string name = RunFolder::validation(i);
    data::Dataset own = data::load_dataset(folder.recording(name));
    const std::vector<std::string> joints = own.joint_names;
    add_recording(held_out, std::move(own), joints, folder.recording(name),
                  truth_in(folder.truth(name)), folder.truth(name), cutoff);
  }
  const dynamics::RobotModel& robot = problem.robot;
  const std::map<std::string, double>& fix = problem.scene.robot.fix;
  for (const FurtherData& further : further_data) {
    const data::Dataset read = data::load_dataset(further.file);
    if (fix.empty() && read.n() != robot.n())
      throw UserError("{}: {} joints; allowed: {}, those of the robot of the run, {}; found {}",
                      further.file.string(), read.n(), robot.n(),
                      fmt::join(problem.scene.joints, " "), fmt::join(read.joint_names, " "));
    data::Dataset own = joints_of(read, robot, "the robot of the run", further.file.string(), fix);
    refuse_training(own, training, further.file);
    refuse_again(own, held_out.trajectories, further.file);
    own.name = further.name;
    const fs::path truth = truth_beside(further.file);
    add_recording(held_out, std::move(own), read.joint_names, further.file,
                  truth_of(problem, truth, say), truth, cutoff);
  }
  if (held_out.trajectories.empty())
    throw UserError("{}: found no validation data to evaluate on",
                    (folder.path() / "data").string());
  if (!held_out.truths.empty() && held_out.truths.size() != held_out.trajectories.size())
    throw UserError("--data: found recordings with and without truth; evaluate them separately");
  require_horizons(problem.scene, held_out);
  return held_out;
}

}  // namespace fricid::workflow
