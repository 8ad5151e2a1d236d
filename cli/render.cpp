// `fricid render`.
#include <fmt/format.h>
#include <algorithm>

#include "fricid/base/error.hpp"
#include "fricid/film/video.hpp"
#include "fricid/workflow/section.hpp"
#include "job.hpp"
#include "outputs.hpp"

namespace fricid::cli {

Verdict render(const RenderOptions& options, const CommonOptions& common) {
  workflow::require_run_folder(options.target);
  RunOptions folder;
  folder.target = options.target;
  workflow::Job job = open_job(workflow::load_problem(options.target), folder, common);
  scene::Scene scene = job.problem.scene;
  if (const auto quality = value_named<film::Quality>(options.quality))
    scene.render.quality = *quality;
  if (const auto layout = value_named<film::Layout>(options.layout)) scene.render.layout = *layout;
  const scene::Problem shown = workflow::with_scene(job.problem, std::move(scene));

  const auto wanted = [&](const char* what) {
    return std::find(options.what.begin(), options.what.end(), what) != options.what.end();
  };
  std::vector<std::string> missed;
  if (options.what.empty() || wanted("plots")) missed.push_back(workflow::draw_plots(job));
  if (options.what.empty() || wanted("video"))
    missed.push_back(workflow::make_videos(job, shown, options.renderer));
  if (options.what.empty() || wanted("report")) workflow::make_report(job);
  std::erase(missed, "");
  if (wanted("still")) {
    std::vector<std::filesystem::path> inputs = job.problem.inputs;
    for (const auto& file : {job.run.folder().manifest(), job.run.folder().scene()})
      inputs.push_back(file);
    for (const workflow::StageRecord& stage : job.run.manifest().stages)
      for (const workflow::Content& output : stage.outputs)
        inputs.push_back(job.run.folder().path() / output.name);
    require_not_input("-o", options.still, inputs);
    job.run.results_of("evaluate");  // refuses one of former data
    film::render_still(job.run.folder(), shown, options.at, options.still,
                       {.renderer = options.renderer});
  }
  if (!missed.empty()) throw UserError("{}", fmt::join(missed, "; "));
  return Verdict::kDone;
}

}  // namespace fricid::cli
