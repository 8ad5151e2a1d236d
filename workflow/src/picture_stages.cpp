// The stages that draw: plots, videos, the report. They read only files of the run.
#include <fmt/format.h>
#include <algorithm>
#include <cstdio>

#include "fricid/base/attempts.hpp"
#include "fricid/base/error.hpp"
#include "fricid/base/parallel.hpp"
#include "fricid/base/progress.hpp"
#include "fricid/data/artefact.hpp"
#include "fricid/film/video.hpp"
#include "fricid/render/figures.hpp"
#include "fricid/render/report.hpp"
#include "fricid/workflow/job.hpp"
#include "fricid/workflow/section.hpp"

namespace fricid::workflow {
namespace {

using enum Section;

constexpr Section kDrawn[] = {kRobot};
constexpr Section kFilmed[] = {kName, kDescription, kRobot, kFriction, kRender};
constexpr Section kReported[] = {kName,     kDescription, kSeed,       kRobot,   kFriction,
                                 kPlant,    kController,  kExcitation, kSensors, kData,
                                 kIdentify, kModels,      kEvaluate,   kPayload, kCompensation,
                                 kContact,  kRender};

/// Declares the outputs of data, fits, evaluation and closed loops.
void declare_results(Inputs& inputs, const Job& job) {
  inputs.outputs_of(job.run.results_of("data"));
  for (const FitRequest& fit : fits_of(job).counted)
    inputs.outputs_of(job.run.results_of(fit_stage(job, fit).name));
  inputs.outputs_of(job.run.results_of("evaluate"));
  if (job.problem.scene.payload.wanted())
    inputs.outputs_of(job.run.results_of(payload_stage(job).name));
  if (job.problem.scene.compensation.wanted())
    inputs.outputs_of(job.run.results_of(compensation_stage(job).name));
  if (job.problem.scene.contact.wanted())
    inputs.outputs_of(job.run.results_of(contact_stage(job).name));
}

/// @throws UserError, after all others are made, when some could not be
Done write_figures(const RunFolder& visible, const RunFolder& out, int jobs) {
  const auto figures = render::figures_of_run(visible);
  Progress progress("plots", static_cast<double>(figures.size()));
  std::vector<std::vector<std::filesystem::path>> files(figures.size());
  std::vector<Attempts> attempts(figures.size());
  parallel_for(static_cast<int>(figures.size()), jobs, [&](int figure) {
    const auto i = static_cast<std::size_t>(figure);
    attempts[i].try_to([&] { files[i] = render::write_figure(figures[i], out.plots()); });
    progress.advance(1, figures[i].name);
  });
  Attempts all;
  for (const Attempts& figure : attempts) all.try_to([&] { figure.finish(); });
  all.finish();
  Done done;
  for (const auto& of_figure : files)
    done.files.insert(done.files.end(), of_figure.begin(), of_figure.end());
  return done;
}

/// Does an optional stage.
/// @return why it could not be done; empty if it was
std::string attempt(Job& job, const std::string& name, const std::function<Stage()>& make) {
  try {
    if (!job.run.perform(make())) job.say(name + ": up to date");
    return {};
  } catch (const UserError& error) {
    return name + ": " + error.what();
  }
}

}  // namespace

Stage plots_stage(const Job& job) {
  Stage stage{"plots", Inputs(job.run.folder()), {}};
  declare(stage.inputs, job.problem, kDrawn);
  declare_results(stage.inputs, job);
  stage.inputs.files_below(job.run.folder().estimates());
  stage.work = [out = job.run.folder(), jobs = job.jobs](const RunFolder& visible) {
    return write_figures(visible, out, jobs);
  };
  return stage;
}

Stage film_stage(const Job& job, const scene::Problem& shown, const std::string& renderer) {
  Stage stage{"video", Inputs(job.run.folder()), {}};
  declare(stage.inputs, shown, kFilmed);
  stage.inputs.text("MJCF", job.mjcf);
  declare_results(stage.inputs, job);
  stage.inputs.text("renderer", renderer);
  stage.work = [part = part_of(shown, kFilmed), out = job.run.folder(), jobs = job.jobs,
                renderer](const RunFolder& visible) {
    return Done{film::render_video(visible, out, part, {.renderer = renderer, .jobs = jobs})};
  };
  return stage;
}

Stage report_stage(const Job& job) {
  Stage stage{"report", Inputs(job.run.folder()), {}};
  declare(stage.inputs, job.problem, kReported);
  declare_results(stage.inputs, job);
  // not only those recorded: plots may be restyled by hand
  stage.inputs.files_below(job.run.folder().plots());
  stage.inputs.files_below(job.run.folder().videos());
  // the report shows the manifest's program and all other stages
  Manifest shown = job.run.manifest();
  std::erase_if(shown.stages, [](const StageRecord& record) { return record.name == "report"; });
  stage.inputs.text("manifest", data::to_json(shown));
  stage.work = [shown, part = part_of(job.problem, kReported),
                out = job.run.folder()](const RunFolder& visible) {
    render::write_report(visible, part.scene, shown, out.report());
    return Done{{out.report()}};
  };
  return stage;
}

std::string draw_plots(Job& job) {
  return attempt(job, "plots", [&] { return plots_stage(job); });
}

std::string make_videos(Job& job, const scene::Problem& shown, const std::string& renderer) {
  return attempt(job, "video", [&] { return film_stage(job, shown, renderer); });
}

void make_report(Job& job) {
  if (!job.run.perform(report_stage(job))) job.say("report: up to date");
}

}  // namespace fricid::workflow
