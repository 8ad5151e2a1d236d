// `fricid render` and its stages: pictures from the files of a run folder.
#include <algorithm>
#include <cstdio>

#include "fricid/base/attempts.hpp"
#include "fricid/base/progress.hpp"
#include "fricid/film/video.hpp"
#include "fricid/render/figures.hpp"
#include "stages.hpp"

namespace fricid::cli {
namespace {

/// Does a stage that the job can do without.
/// @return why it could not be done
std::string try_stage(Job& job, const std::string& name, const std::string& key,
                      const std::function<std::vector<std::string>()>& body) {
  try {
    if (!job.folder.stage(name, key, body)) std::fprintf(stderr, "%s: up to date\n", name.c_str());
    return {};
  } catch (const UserError& error) {
    return name + ": " + error.what();
  }
}

/// @throws UserError, after all others are made, when some could not be
std::vector<std::string> write_figures(const std::filesystem::path& folder) {
  std::vector<std::string> files;
  const auto figures = render::figures_of_run(folder);
  Progress progress("plots", static_cast<double>(figures.size()));
  Attempts attempts;
  for (const render::Figure& figure : figures) {
    throw_if_stopped();
    attempts.try_to([&] { render::write_figure(figure, folder / "plots"); });
    progress.advance(1, figure.name);
    for (const char* extension : {".gp", ".pdf", ".svg", ".png"})
      files.push_back("plots/" + figure.name + extension);
  }
  attempts.finish();
  return files;
}

/// What data, fits and evaluation left, as text for keys.
std::string key_of_results(const Job& job) {
  std::string key = job.folder.outputs_of("data") + job.folder.outputs_of("evaluate");
  for (const std::string& id : fits_of(job).counted) key += job.folder.outputs_of("identify " + id);
  return key;
}

}  // namespace

std::string draw_plots(Job& job) {
  return try_stage(job, "plots", data::to_toml(job.problem.scene) + key_of_results(job),
                   [&] { return write_figures(job.folder.path()); });
}

std::string make_videos(Job& job, const data::Problem& shown, const std::string& renderer) {
  data::Scene read;
  read.render = shown.scene.render;
  const std::string key = key_of_results(job) + key_of_robot(job.problem) + data::to_toml(read) +
                          job.problem.scene.description + renderer;
  return try_stage(job, "video", key, [&] {
    return film::render_video(job.folder.path(), shown, {.renderer = renderer, .jobs = job.jobs});
  });
}

Verdict render(const RenderOptions& options, const CommonOptions& common) {
  require_run_folder(options.target);
  RunOptions folder;
  folder.target = options.target;
  Job job = open_job(load_problem(folder), folder, common);
  data::Scene scene = job.problem.scene;
  if (!options.quality.empty()) scene.render.quality = options.quality;
  if (!options.layout.empty()) scene.render.layout = options.layout;
  const data::Problem shown = data::resolve(std::move(scene));

  const auto wanted = [&](const char* what) {
    return std::find(options.what.begin(), options.what.end(), what) != options.what.end();
  };
  std::vector<std::string> missed;
  if (options.what.empty() || wanted("plots")) missed.push_back(draw_plots(job));
  if (options.what.empty() || wanted("video"))
    missed.push_back(make_videos(job, shown, options.renderer));
  if (options.what.empty() || wanted("report")) make_report(job);
  std::erase(missed, "");
  if (wanted("still"))
    film::render_still(job.folder.path(), shown, options.at, options.still,
                       {.renderer = options.renderer});
  if (!missed.empty()) throw UserError("{}", fmt::join(missed, "; "));
  return Verdict::kDone;
}

}  // namespace fricid::cli
