#include "commands.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <map>
#include <utility>
#include <vector>

#include "fricid/base/error.hpp"
#include "fricid/base/files.hpp"
#include "fricid/base/names.hpp"
#include "fricid/data/artefact.hpp"
#include "fricid/evaluate/compare.hpp"
#include "fricid/evaluate/evaluate.hpp"
#include "fricid/evaluate/warnings.hpp"
#include "fricid/workflow/payload.hpp"
#include "job.hpp"
#include "seeds.hpp"
#include "terminal.hpp"

namespace fricid::cli {
namespace {

namespace fs = std::filesystem;

void say(const std::string& line) { print(printable(line) + "\n", stderr); }

fs::path folder_of(const RunOptions& options, const scene::Problem& problem) {
  if (!options.output.empty()) return options.output;
  if (workflow::is_run_folder(options.target)) return options.target;
  const std::string name =
      options.seed ? fmt::format("{}_{}", problem.scene.name, *options.seed) : problem.scene.name;
  return fs::path("run") / name;
}

/// The fits that the options ask for.
struct Requests {
  std::vector<workflow::FitRequest> fits;
  bool by_name;  ///< chosen by --model or --seeds
};

Requests requests_of(const scene::Problem& problem, const RunOptions& options) {
  return {workflow::requested_fits(
              problem.scene, options.models,
              options.seeds.empty() ? std::vector<int>() : parse_seeds(options.seeds)),
          !options.models.empty() || !options.seeds.empty()};
}

scene::Problem problem_of(const RunOptions& options) {
  return workflow::load_problem(options.target, options.seed);
}

void print_file(const fs::path& file) { print(read_file(file)); }
void print_json_file(const fs::path& file) { print(visible_json(read_file(file))); }

/// The tables of an evaluation.
void print_tables(const workflow::Job& job) {
  const workflow::RunFolder& folder = job.run.folder();
  print_file(folder.table());
  if (job.problem.scene.simulates()) return;
  print("\n");
  print_file(folder.torque_table());
}

/// Prints what must not be trusted, and horizons that rank nothing. @return whether there is none
bool trusted(const evaluate::Evaluation& evaluation) {
  std::vector<std::pair<std::string, std::vector<std::string>>> doubts;  // and the models of each
  for (const evaluate::Summary& summary : evaluation.summary)
    for (const std::string& doubt : summary.doubts) {
      auto known = std::ranges::find(doubts, doubt, &decltype(doubts)::value_type::first);
      if (known == doubts.end()) known = doubts.insert(known, {doubt, {}});
      known->second.push_back(summary.label);
    }
  for (const auto& [doubt, labels] : doubts)
    say(fmt::format("not to be trusted: {}: {}", fmt::join(labels, ", "), doubt));
  for (const evaluate::Unexplained& torque : evaluation.unexplained) {
    const evaluate::Warning warning = evaluate::warning_of(torque);
    say(fmt::format("does not belong: {}: {}; {}; remedy: {}", warning.subject, warning.found,
                    warning.meaning, warning.remedy));
  }
  for (const std::string& why : evaluation.meaningless)
    if (!why.empty()) say("cannot rank models at " + why);
  return evaluation.trusted() && evaluation.meaningful();
}

/// Short result of a run, and the paths of its files.
void print_result(const workflow::Job& job, const evaluate::Evaluation& evaluation) {
  const workflow::RunFolder& folder = job.run.folder();
  print(evaluate::short_table(evaluation, workflow::fit_seconds(job.run.manifest())));
  const scene::Scene& scene = job.problem.scene;
  if (scene.payload.wanted())
    print(fmt::format("\n{}", workflow::to_text(data::load<data::PayloadFile>(folder.payload()))));
  for (const auto& [made, table] :
       {std::pair(scene.compensation.wanted(), folder.compensation_table()),
        std::pair(scene.contact.wanted(), folder.contact_table())})
    if (made) {
      print("\n");
      print_file(table);
    }
  const auto place = [](const char* what, const fs::path& path) {
    if (fs::exists(path)) print(fmt::format("{:<8} {}\n", what, printable(path.string())));
  };
  print("\n");
  place("report", folder.report());
  place("tables", folder.table());
  place("plots", folder.plots());
  place("videos", folder.videos());
  place("models", folder.models());
}

}  // namespace

workflow::Job open_job(scene::Problem problem, const RunOptions& options,
                       const CommonOptions& common) {
  const fs::path folder = folder_of(options, problem);
  return workflow::open_job(std::move(problem), folder, common.fresh, common.jobs, say);
}

Verdict run(const RunOptions& options, const CommonOptions& common) {
  scene::Problem problem = problem_of(options);
  workflow::require_models(problem.scene);
  workflow::require_validation(problem.scene);
  scene::require_horizons(problem.scene);
  scene::require_logs(problem);
  const Requests requests = requests_of(problem, options);
  workflow::require_memory(problem, requests.fits, common.jobs);
  workflow::Job job = open_job(std::move(problem), options, common);
  workflow::make_data(job);
  const bool sound = workflow::data_are_sound(job);
  bool healthy = workflow::identify(job, requests.fits, requests.by_name);
  const evaluate::Evaluation evaluation = workflow::evaluate(job, options.data);
  healthy = workflow::find_load(job) && healthy;
  workflow::compensate(job);
  workflow::feel_contacts(job);
  const bool videos = job.problem.scene.render.video && !options.no_video;
  for (const std::string& missed :
       {workflow::draw_plots(job),
        videos ? workflow::make_videos(job, job.problem, {}) : std::string()})
    if (!missed.empty()) say(missed);
  workflow::make_report(job);
  if (common.json)
    print_json_file(job.run.folder().evaluation());
  else
    print_result(job, evaluation);
  return trusted(evaluation) && sound && healthy ? Verdict::kDone : Verdict::kNo;
}

Verdict simulate(const RunOptions& options, const CommonOptions& common) {
  scene::Problem problem = problem_of(options);
  if (!problem.scene.simulates())
    throw UserError("{}: found no [friction]; the scene imports logs, use `fricid run`",
                    options.target.string());
  workflow::Job job = open_job(std::move(problem), options, common);
  workflow::make_data(job);
  print(printable(job.run.folder().path().string()) + "\n");
  return Verdict::kDone;
}

namespace {

/// @throws UserError where its evaluation is missing or outdated
evaluate::ComparedRun compared_run(const fs::path& path) {
  const workflow::RunFolder folder(path);
  if (!fs::exists(folder.evaluation()))
    throw UserError("{}: found no evaluation; run `fricid evaluate` first",
                    folder.evaluation().string());
  evaluate::ComparedRun run{
      path.string(), data::load<evaluate::Evaluation>(folder.evaluation()), {}};
  if (!workflow::is_run_folder(path)) return run;
  const auto manifest = data::load<workflow::Manifest>(folder.manifest());
  if (const std::string why = workflow::outdated(folder, manifest, folder.evaluation());
      !why.empty())
    throw UserError("{}: {}; `fricid evaluate {}` makes it again", folder.evaluation().string(),
                    why, path.string());
  run.fit_seconds = workflow::fit_seconds(manifest);
  run.problem = workflow::problem_key(manifest);
  run.fits = workflow::fit_keys(manifest);
  return run;
}

}  // namespace

Verdict compare(const CompareOptions& options, const CommonOptions& common) {
  std::vector<evaluate::ComparedRun> runs;
  std::map<fs::path, fs::path> seen;
  for (const fs::path& path : options.folders) {
    const auto [other, first] = seen.try_emplace(fs::weakly_canonical(path / ""), path);
    if (!first)
      throw UserError("{}: the folder of {}; allowed: each run once", path.string(),
                      other->second.string());
    runs.push_back(compared_run(path));
  }
  const evaluate::Comparison comparison = evaluate::compare_runs(runs, options.against);
  const std::string text =
      common.json ? data::to_json(comparison) : evaluate::to_markdown(comparison);
  if (options.output.empty())
    print(common.json ? visible_json(text) : text);
  else
    write_file_atomically(options.output, text);
  return Verdict::kDone;
}

Verdict identify(const RunOptions& options, const CommonOptions& common) {
  scene::Problem problem = problem_of(options);
  if (options.models.empty()) workflow::require_models(problem.scene);
  scene::require_logs(problem);
  const Requests requests = requests_of(problem, options);
  workflow::require_memory(problem, requests.fits, common.jobs);
  workflow::Job job = open_job(std::move(problem), options, common);
  workflow::make_data(job);
  const bool sound = workflow::data_are_sound(job);
  const bool healthy = workflow::identify(job, requests.fits, requests.by_name);
  return sound && healthy ? Verdict::kDone : Verdict::kNo;
}

Verdict evaluate(const RunOptions& options, const CommonOptions& common) {
  workflow::require_run_folder(options.target);
  scene::Problem problem = problem_of(options);
  if (options.data.empty()) workflow::require_validation(problem.scene);
  workflow::Job job = open_job(std::move(problem), options, common);
  const bool sound = workflow::data_are_sound(job);
  const evaluate::Evaluation evaluation = workflow::evaluate(job, options.data);
  if (common.json)
    print_json_file(job.run.folder().evaluation());
  else
    print_tables(job);
  return trusted(evaluation) && sound ? Verdict::kDone : Verdict::kNo;
}

}  // namespace fricid::cli
