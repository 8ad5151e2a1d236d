#include "fricid/workflow/job.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "fricid/base/error.hpp"
#include "fricid/base/files.hpp"
#include "fricid/data/log_part.hpp"
#include "fricid/estimate/prior.hpp"
#include "fricid/sim/simulate.hpp"

namespace fricid::workflow {
namespace {

namespace fs = std::filesystem;

/// @throws UserError when an input is in the folders that the run writes: it might be overwritten
void refuse_sources_inside(const scene::Problem& problem, const RunFolder& folder) {
  const fs::path inside = fs::weakly_canonical(folder.path());
  const fs::path own_scene = fs::weakly_canonical(folder.scene());
  for (const fs::path& source : problem.inputs) {
    const fs::path path = fs::weakly_canonical(source);
    const fs::path relative = path.lexically_relative(inside);
    if (path != own_scene && !relative.empty() && *relative.begin() != "..")
      throw UserError("{}: lies in the run folder {}; allowed: inputs outside of it",
                      source.string(), folder.path().string());
  }
}

/// A log of the scene, and what tells it from others.
struct KnownLog {
  std::string name;
  data::LogPart part;
  std::string sha256;

  bool shares_samples_with(const KnownLog& other) const {
    return part.overlaps(other.part) && sha256 == other.sha256;
  }
};

std::vector<KnownLog> known(const scene::Problem& problem, const std::vector<std::string>& logs) {
  std::vector<KnownLog> found;
  for (const std::string& log : logs)
    found.push_back({log, data::log_part(log), sha256_of_file(scene::find_log(problem, log))});
  return found;
}

/// @throws UserError when two logs of a key have samples in common
void refuse_repeated_logs(const scene::Problem& problem, std::string_view key,
                          const std::vector<KnownLog>& logs) {
  for (auto log = logs.begin(); log != logs.end(); ++log) {
    const auto first = std::find_if(logs.begin(), log, [&](const KnownLog& before) {
      return before.shares_samples_with(*log);
    });
    if (first != log)
      throw UserError("{}: data.{} has {}, whose samples are in {} too; allowed: each sample once",
                      problem.scene.name, key, log->name, first->name);
  }
}

/// @throws UserError when samples count twice: of two logs, or learnt and judged
void refuse_shared_logs(const scene::Problem& problem) {
  const std::vector<KnownLog> train = known(problem, problem.scene.data.train),
                              validation = known(problem, problem.scene.data.validation);
  refuse_repeated_logs(problem, "train", train);
  refuse_repeated_logs(problem, "validation", validation);
  for (const KnownLog& learnt : train)
    for (const KnownLog& judged : validation)
      if (learnt.shares_samples_with(judged))
        throw UserError(
            "{}: data.validation has {}, which is trained on as {}; allowed: other recordings, or "
            "parts of one by seconds: train = [\"{}[0:20]\"], validation = [\"{}[20:]\"]",
            problem.scene.name, judged.name, learnt.name, learnt.part.file, judged.part.file);
}

/// @throws UserError when a prior is not there, or of another robot
void require_priors_of_robot(const scene::Problem& problem) {
  scene::require_priors(problem);
  for (const estimate::ModelOptions& model : problem.scene.models)
    if (!model.prior.empty()) estimate::load_prior(model.prior, problem.robot);
}

/// @param ran  whether the scene is that of a run folder, whose arm was compared with the URDF
/// before
scene::Problem checked_problem(scene::Scene scene, std::optional<std::uint64_t> seed, bool ran) {
  if (seed) scene.seed = *seed;
  scene::Problem problem = scene::resolve(std::move(scene));
  if (!ran) require_priors_of_robot(problem);
  if (!ran && problem.scene.simulates()) sim::make_arm(problem);
  if (scene::logs_are_there(problem)) refuse_shared_logs(problem);
  return problem;
}

}  // namespace

scene::Problem load_problem(const fs::path& target, std::optional<std::uint64_t> seed) {
  const bool ran = is_run_folder(target);
  return checked_problem(scene::load_scene(ran ? RunFolder(target).scene() : target), seed, ran);
}

scene::Problem load_problem_text(const std::string& text, std::optional<std::uint64_t> seed) {
  return checked_problem(scene::load_scene_text(text), seed, false);
}

Job open_job(scene::Problem problem, const fs::path& path, bool fresh, int jobs,
             std::function<void(const std::string&)> say) {
  refuse_sources_inside(problem, RunFolder(path));
  std::string mjcf =
      problem.mjcf_path.empty() ? std::string() : sim::compiled_mjcf(problem.mjcf_path);
  Job job{std::move(problem), std::move(mjcf), Run::open(path, fresh), jobs, std::move(say)};
  job.run.describe([&](Manifest& manifest) {
    manifest.scene = job.problem.scene.name;
    manifest.seed = job.problem.scene.seed;
    manifest.sources.clear();
    for (const fs::path& source : job.problem.inputs)
      manifest.sources.push_back({source.string(), sha256_of_file(source)});
  });
  const fs::path scene = job.run.folder().scene();
  const std::string text = scene::to_toml(job.problem.scene);
  if (!fs::exists(scene) || read_file(scene) != text) write_file_atomically(scene, text);
  return job;
}

}  // namespace fricid::workflow
