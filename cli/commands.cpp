#include "commands.hpp"

#include <cstdio>

#include "fricid/base/error.hpp"
#include "fricid/data/paths.hpp"
#include "fricid/evaluate/compare.hpp"
#include "stages.hpp"

namespace fricid::cli {
namespace {

void print_result(const Job& job, const CommonOptions& common) {
  const auto print = [&](const char* name) {
    std::fputs(read_file(job.folder.path() / name).c_str(), stdout);
  };
  if (common.json) return print("evaluation.json");
  print("table.md");
  if (!job.problem.scene.simulates()) {
    std::fputs("\n", stdout);
    print("torque.md");
  }
}

/// Logs that are not there: said, not failed, and no folder made.
bool skipped(const data::Problem& problem) {
  std::string why;
  if (data::data_available(problem, &why)) return false;
  std::fprintf(stderr, "skipped: %s\n", why.c_str());
  return true;
}

}  // namespace

Verdict run(const RunOptions& options, const CommonOptions& common) {
  data::Problem problem = load_problem(options);
  if (skipped(problem)) return Verdict::kDone;
  Job job = open_job(std::move(problem), options, common);
  make_data(job);
  const bool healthy = identify_models(job, options.models, options.seeds);
  const bool meaningful = evaluate_models(job, options.data);
  const bool videos = job.problem.scene.render.video && !options.no_video;
  for (const std::string& missed :
       {draw_plots(job), videos ? make_videos(job, job.problem, {}) : std::string()})
    if (!missed.empty()) std::fprintf(stderr, "%s\n", missed.c_str());
  make_report(job);
  print_result(job, common);
  return healthy && meaningful ? Verdict::kDone : Verdict::kNo;
}

Verdict simulate(const RunOptions& options, const CommonOptions& common) {
  data::Problem problem = load_problem(options);
  if (!problem.scene.simulates())
    throw UserError("{}: found no [friction]; the scene imports logs, use `fricid run`",
                    options.target.string());
  Job job = open_job(std::move(problem), options, common);
  make_data(job);
  std::printf("%s\n", job.folder.path().c_str());
  return Verdict::kDone;
}

Verdict compare(const std::vector<std::filesystem::path>& folders,
                const std::filesystem::path& output, const CommonOptions& common) {
  const std::vector<evaluate::ComparedScene> scenes = evaluate::compare_runs(folders);
  const std::string text = common.json ? evaluate::to_json(scenes) : evaluate::to_markdown(scenes);
  if (output.empty())
    std::fputs(text.c_str(), stdout);
  else
    write_file_atomically(output, text);
  return Verdict::kDone;
}

Verdict identify(const RunOptions& options, const CommonOptions& common) {
  data::Problem problem = load_problem(options);
  if (skipped(problem)) return Verdict::kDone;
  Job job = open_job(std::move(problem), options, common);
  make_data(job);
  return identify_models(job, options.models, options.seeds) ? Verdict::kDone : Verdict::kNo;
}

Verdict evaluate(const RunOptions& options, const CommonOptions& common) {
  require_run_folder(options.target);
  Job job = open_job(load_problem(options), options, common);
  const bool meaningful = evaluate_models(job, options.data);
  print_result(job, common);
  return meaningful ? Verdict::kDone : Verdict::kNo;
}

}  // namespace fricid::cli
