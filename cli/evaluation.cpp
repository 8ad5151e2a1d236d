// The evaluation stage: gathers held-out data, truth and models; scoring is done by
// fricid::evaluate.
#include <cstdio>
#include <nlohmann/json.hpp>

#include "fricid/base/error.hpp"
#include "fricid/base/names.hpp"
#include "fricid/base/parallel.hpp"
#include "fricid/data/hdf5.hpp"
#include "fricid/estimate/filter.hpp"
#include "fricid/evaluate/evaluate.hpp"
#include "fricid/evaluate/evaluation_file.hpp"
#include "fricid/sim/simulate.hpp"
#include "stages.hpp"

namespace fricid::cli {
namespace {

namespace fs = std::filesystem;

/// Held-out recordings with their truth, where there is one.
struct HeldOut {
  std::vector<evaluate::Trajectory> trajectories;
  std::vector<sim::Truth> truths;  ///< as many as trajectories, or none
};

void add_recording(HeldOut& held_out, const fs::path& data_file, const fs::path& truth_file,
                   double cutoff_hz) {
  evaluate::Trajectory trajectory;
  trajectory.data = data::load_dataset(data_file);
  estimate::Filtered motion = estimate::filter_dataset(trajectory.data, cutoff_hz);
  trajectory.q = std::move(motion.q);
  trajectory.v = std::move(motion.v);
  trajectory.a = std::move(motion.a);
  if (fs::exists(truth_file)) {
    held_out.truths.push_back(sim::load_truth(truth_file));
    const sim::Trace& trace = held_out.truths.back().trace;
    trajectory.truth = evaluate::Reference{trace.q, trace.v, trace.tau_f, trace.z};
  }
  held_out.trajectories.push_back(std::move(trajectory));
}

HeldOut load_held_out(const Job& job, const std::vector<fs::path>& further_data) {
  HeldOut held_out;
  const fs::path& folder = job.folder.path();
  const double cutoff = job.problem.scene.identify.cutoff_hz;
  for (int i = 0;; ++i) {
    const std::string name = fmt::format("validation_{}.h5", i);
    if (!fs::exists(folder / "data" / name)) break;
    add_recording(held_out, folder / "data" / name, folder / "truth" / name, cutoff);
  }
  for (const fs::path& file : further_data)
    add_recording(held_out, file, file.parent_path().parent_path() / "truth" / file.filename(),
                  cutoff);
  if (held_out.trajectories.empty())
    throw UserError("{}: found no validation data to evaluate on", (folder / "data").string());
  if (!held_out.truths.empty() && held_out.truths.size() != held_out.trajectories.size())
    throw UserError("--data: found recordings with and without truth; evaluate them apart");
  return held_out;
}

/// The truth rolled out by the simulator at its own step times `share`, one rollout per planned
/// start.
std::vector<evaluate::Rollout> simulator_rollouts(const Job& job, const HeldOut& held_out,
                                                  std::span<const evaluate::Start> starts,
                                                  double share) {
  const sim::MujocoArm arm = sim::make_arm(job.problem, job.problem.scene.plant.step_s * share);
  std::vector<evaluate::Rollout> rollouts(starts.size());
  parallel_for(static_cast<int>(starts.size()), job.jobs, [&](int i) {
    const evaluate::Start& start = starts[static_cast<std::size_t>(i)];
    const auto trajectory = static_cast<std::size_t>(start.trajectory);
    const sim::Trace trace =
        sim::oracle_rollout(job.problem, arm, held_out.truths[trajectory],
                            held_out.trajectories[trajectory].data, start.begin, start.steps + 1);
    rollouts[static_cast<std::size_t>(i)] = {start, false, trace.q, trace.v, trace.tau_f};
  });
  return rollouts;
}

/// The recordings that the models were fitted to, driven by the motion that fits see.
std::vector<evaluate::Trajectory> load_training(const Job& job) {
  std::vector<evaluate::Trajectory> training;
  for (int i = 0;; ++i) {
    const fs::path file = job.folder.path() / "data" / fmt::format("train_{}.h5", i);
    if (!fs::exists(file)) return training;
    evaluate::Trajectory& recording = training.emplace_back();
    recording.data = data::load_dataset(file);
    estimate::Filtered motion =
        estimate::filter_dataset(recording.data, job.problem.scene.identify.cutoff_hz);
    recording.q = std::move(motion.q_wide);
    recording.v = std::move(motion.v_wide);
  }
}

data::ModelFile oracle_model(const data::Problem& problem) {
  data::ModelFile model;
  model.name = model.label = "oracle";
  model.arm = {problem.robot, *problem.scene.friction};
  model.is_oracle = true;
  return model;
}

std::vector<data::ModelFile> load_models(const Job& job) {
  std::vector<data::ModelFile> models;
  const Fits fits = fits_of(job);
  for (const std::string& id : fits.left_out)
    std::fprintf(stderr,
                 "%s: left out: it was not fitted to this scene, robot and data as they are now\n",
                 printable(id).c_str());
  for (const std::string& id : fits.counted) {
    const std::string name = id + ".json";
    models.push_back(data::load_model(job.folder.path() / "models" / name));
    const auto fit =
        nlohmann::json::parse(read_file(job.folder.path() / "fit" / name), nullptr, false);
    if (!fit.is_discarded()) models.back().fit_seconds = fit.value("seconds", 0.0);
  }
  if (models.empty())
    throw UserError("{}: found no models; run `fricid identify` first",
                    (job.folder.path() / "models").string());
  return models;
}

/// Folders of external/, sorted by name. @throws UserError when something else is there, or a name
/// is taken or cannot be one
std::vector<fs::path> external_folders(const fs::path& run,
                                       const std::vector<data::ModelFile>& models) {
  std::vector<fs::path> folders;
  if (!fs::exists(run / "external")) return folders;
  for (const auto& entry : fs::directory_iterator(run / "external")) {
    const std::string name = entry.path().filename().string(), shown = entry.path().string();
    if (name.starts_with('.')) continue;
    if (!entry.is_directory()) throw UserError("{}: a file; allowed: one folder per model", shown);
    if (!std::all_of(name.begin(), name.end(), [](unsigned char c) {
          return std::isalnum(c) != 0 || c == '_' || c == '-' || c == '.';
        }))
      throw UserError("{}: found this name; allowed: letters, digits, _, - and .", shown);
    const bool taken = name == "oracle" || name == "simulator" ||
                       std::any_of(models.begin(), models.end(), [&](const data::ModelFile& model) {
                         return model.name == name;
                       });
    if (taken) throw UserError("{}: a model of this run has this name", shown);
    folders.push_back(entry.path());
  }
  std::sort(folders.begin(), folders.end());
  return folders;
}

/// Names and hashes of what is in a folder, sorted.
std::string contents_of(const fs::path& folder) {
  std::vector<std::string> files;
  for (const auto& entry : fs::recursive_directory_iterator(folder))
    if (entry.is_regular_file())
      files.push_back(entry.path().string() + sha256_of_file(entry.path()));
  std::sort(files.begin(), files.end());
  return fmt::format("{}", fmt::join(files, ""));
}

/// Whether a model is a convention to beat: no network, and fitted as is the custom.
bool is_conventional(const data::Problem& problem, const data::ModelFile& model) {
  if (model.arm.friction.model.has_whole()) return false;
  for (const friction::JointSpec& joint : model.arm.friction.model.joints())
    for (const friction::LawSpec& law : joint.laws)
      if (friction::is_learned(law.law)) return false;
  for (const data::ModelConfig& config : problem.scene.models)
    if (config.name == model.name) return config.method == "conventional";
  return true;
}

/// @throws UserError when the data are damaged, or not those of the scene as it is now
void refuse_other_data(const Job& job) {
  const bool logs = data::data_available(job.problem, nullptr);
  if (!job.folder.intact("data") || (logs && !job.folder.stands("data", key_of_data(job.problem))))
    throw UserError(
        "{}: the data are damaged, or not those of the scene, robot and logs as they are now; "
        "`fricid run {}` makes them again",
        (job.folder.path() / "data").string(), job.folder.path().string());
}

}  // namespace

bool evaluate_models(Job& job, const std::vector<fs::path>& further_data) {
  refuse_other_data(job);
  const std::vector<data::ModelFile> models = load_models(job);
  const std::vector<fs::path> externals = external_folders(job.folder.path(), models);
  data::Scene read = job.problem.scene;
  read.render = {};
  std::string key = data::to_toml(read) + key_of_robot(job.problem) + job.folder.outputs_of("data");
  for (const data::ModelFile& model : models)
    key += sha256_of_file(job.folder.path() / "models" / (id_of(model.name, model.seed) + ".json"));
  for (const fs::path& file : further_data) key += sha256_of_file(file);
  for (const fs::path& folder : externals) key += contents_of(folder);

  const bool ran = job.folder.stage("evaluate", key, [&] {
    const HeldOut held_out = load_held_out(job, further_data);
    const data::EvaluateConfig& options = job.problem.scene.evaluate;
    const auto starts =
        evaluate::plan_starts(held_out.trajectories, options.horizons_s, options.starts);
    write_file_atomically(job.folder.path() / "starts.csv",
                          evaluate::starts_csv(held_out.trajectories, starts));

    evaluate::Contest contest;
    contest.scene = job.problem.scene.name;
    contest.trajectories = held_out.trajectories;
    contest.training = load_training(job);
    contest.models = models;
    contest.robot = job.problem.robot;
    for (const fs::path& folder : externals)
      contest.externals.push_back(
          evaluate::load_external_model(folder, held_out.trajectories, starts));
    for (const data::ModelFile& model : models)
      if (!is_conventional(job.problem, model)) contest.unconventional.push_back(model.name);
    if (!held_out.truths.empty()) {
      contest.models.insert(contest.models.begin(), oracle_model(job.problem));
      contest.simulator_oracle = simulator_rollouts(job, held_out, starts, 1.0);
      contest.simulator_halved = simulator_rollouts(job, held_out, starts, 0.5);
    }
    const evaluate::EvaluationReport report = evaluate::evaluate(contest, options, job.jobs);
    std::vector<std::string> files =
        evaluate::save_report(report, contest.trajectories, job.folder.path());
    files.emplace_back("starts.csv");
    return files;
  });
  if (!ran) std::fputs("evaluate: up to date\n", stderr);

  return evaluate::load_evaluation(job.folder.path()).value("meaningful", true);
}

}  // namespace fricid::cli
