#include "fricid/workflow/job.hpp"

#include <fmt/format.h>

#include "fricid/base/error.hpp"
#include "fricid/base/files.hpp"
#include "fricid/data/log_part.hpp"
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

/// @throws UserError when a validation log has samples in common with a training log
void refuse_shared_logs(const scene::Problem& problem) {
  const scene::DataSection& logs = problem.scene.data;
  for (const std::string& train : logs.train)
    for (const std::string& validation : logs.validation) {
      const data::LogPart learnt = data::log_part(train), judged = data::log_part(validation);
      if (!learnt.overlaps(judged) || sha256_of_file(scene::find_log(problem, train)) !=
                                          sha256_of_file(scene::find_log(problem, validation)))
        continue;
      throw UserError(
          "{}: data.validation has {}, which is trained on as {}; allowed: other recordings, or "
          "parts of one by seconds: train = [\"{}[0:20]\"], validation = [\"{}[20:]\"]",
          problem.scene.name, validation, train, learnt.file, judged.file);
    }
}

/// @param ran  whether the scene is that of a run folder, whose arm was compared with the URDF
/// before
scene::Problem checked_problem(scene::Scene scene, std::optional<std::uint64_t> seed, bool ran) {
  if (seed) scene.seed = *seed;
  scene::Problem problem = scene::resolve(std::move(scene));
  if (!ran) scene::require_priors(problem);
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
