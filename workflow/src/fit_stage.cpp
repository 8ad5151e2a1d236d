// The stages that fit models.
#include <fmt/format.h>
#include <algorithm>
#include <map>
#include <tuple>

#include "fricid/base/error.hpp"
#include "fricid/data/artefact.hpp"
#include "fricid/estimate/fit.hpp"
#include "fricid/evaluate/warnings.hpp"
#include "fricid/workflow/job.hpp"
#include "fricid/workflow/recordings.hpp"
#include "fricid/workflow/section.hpp"

namespace fricid::workflow {
namespace {

using enum Section;

// Fits use the URDF only; a change of the MJCF reaches them through the simulated data.
constexpr Section kFitted[] = {kRobot, kIdentify, kModels};

/// What the fits of one job share.
struct Shared {
  std::optional<estimate::Prepared> prepared;
  std::optional<estimate::ConventionalFits> conventional;
};

Stage make_stage(const Job& job, const FitRequest& request, const std::shared_ptr<Shared>& shared) {
  scene::Scene scene = job.problem.scene;
  scene.models = {request.model};
  scene.models.front().seeds = {request.seed};
  const scene::Problem problem = with_scene(job.problem, std::move(scene));
  Stage stage{stage_of(request.id()), Inputs(job.run.folder()), {}};
  declare(stage.inputs, problem, kFitted);
  stage.inputs.outputs_of(job.run.results_of("data"), kTrainingData);
  if (const std::string& prior = request.model.prior; std::filesystem::exists(prior))
    stage.inputs.file("prior", prior);
  else if (!prior.empty())
    stage.inputs.text("prior", "");  // gone since
  const std::string checkpoint_key = job.run.key_of(stage);
  stage.work = [=, part = part_of(problem, kFitted), out = job.run.folder(), jobs = job.jobs,
                say = job.say](const RunFolder& visible) {
    if (!shared->prepared) {
      shared->prepared = estimate::prepare(
          part.robot, part.scene.identify,
          first_seconds(load_recordings(visible, RunFolder::training, part.scene.joints),
                        part.scene.identify.first_s),
          jobs);
      shared->conventional.emplace(*shared->prepared);
    }
    const FitId id = request.id();
    const estimate::FitReport report =
        estimate::fit_model(*shared->conventional, part.scene.models.front(), request.seed, jobs,
                            {out.checkpoint(id), checkpoint_key});
    data::ModelFile model = report.model;
    model.doubts = report.doubts();
    data::save_model(model, out.model(id));
    data::save(estimate::fit_file(report), out.fit(id));
    say(report.brief());
    return Done{{out.model(id), out.fit(id)},
                report.seconds + shared->prepared->rigid_body.seconds};
  };
  return stage;
}

}  // namespace

std::vector<FitRequest> requested_fits(const scene::Scene& scene,
                                       const std::vector<std::string>& names,
                                       const std::vector<int>& seeds) {
  std::vector<estimate::ModelOptions> models;
  if (names.empty()) models = scene.models;
  for (const std::string& name : names) {
    const auto known = std::ranges::find(scene.models, name, &estimate::ModelOptions::name);
    models.push_back(known != scene.models.end() ? *known : scene::model_of_law(scene, name));
  }
  std::vector<FitRequest> requests;
  for (const estimate::ModelOptions& model : models)
    for (const int seed : seeds.empty() ? model.seeds : seeds) requests.push_back({model, seed});
  return requests;
}

Stage fit_stage(const Job& job, const FitRequest& request) {
  return make_stage(job, request, std::make_shared<Shared>());
}

bool identify(Job& job, const std::vector<FitRequest>& requests, bool by_name) {
  const auto shared = std::make_shared<Shared>();
  std::map<std::vector<std::string>, std::string> told;  // faults, and the first fit that has them
  std::map<std::string, std::string>
      growing;  // friction under load, and the first fit that lacks it
  bool healthy = true;
  for (const FitRequest& request : requests) {
    const std::string id = request.id().name();
    if (by_name)
      job.run.describe([&](Manifest& manifest) {
        if (std::ranges::find(manifest.fitted_by_name, id) == manifest.fitted_by_name.end())
          manifest.fitted_by_name.push_back(id);
      });
    const Stage stage = make_stage(job, request, shared);
    if (!job.run.perform(stage)) job.say(stage.name + ": up to date");
    const auto fit = data::load<data::FitFile>(job.run.folder().fit(request.id()));
    if (fit.rigid_body.slower) job.say(fmt::format("{}: {}", id, *fit.rigid_body.slower));
    if (fit.prior_left_out) job.say(fmt::format("{}: {}", id, *fit.prior_left_out));
    if (fit.remarks)
      for (const data::FittedRemark& remark : *fit.remarks)
        job.say(fmt::format("{}: {}: {}; {}", id, remark.found, remark.meaning, remark.remedy));
    std::vector<std::string> faults;
    for (const data::FittedFault& fault : fit.faults)
      faults.push_back(estimate::in_words({fault.joint, fault.found, fault.remedy}));
    const auto [first, is_new] = told.try_emplace(faults, id);
    if (!is_new && faults.size() > 1)
      faults = {fmt::format("the same {} faults as {}", faults.size(), first->second)};
    for (const std::string& fault : faults) job.say(fmt::format("{}: {}", id, fault));
    if (!fit.usable && fit.faults.empty()) job.say(fmt::format("{}: {}", id, fit.message));
    if (const auto bounds = evaluate::bounds_of(fit, id))
      job.say(fmt::format("{}: {}: {}; {}", id, bounds->found, bounds->meaning, bounds->remedy));
    if (const auto growth = evaluate::growth_of(fit, id, job.problem.scene.joints)) {
      const auto [other, is_first] = growing.try_emplace(growth->found, id);
      job.say(is_first ? fmt::format("{}: {}: {}; {}", id, growth->found, growth->meaning,
                                     growth->remedy)
                       : fmt::format("{}: friction grows with the load, which this law has no more "
                                     "than {}; {}",
                                     id, other->second, growth->remedy));
    }
    healthy = fit.usable && healthy;
  }
  return healthy;
}

Fits fits_of(const Job& job) {
  const auto& models = job.problem.scene.models;
  const auto& by_name = job.run.manifest().fitted_by_name;
  std::vector<std::tuple<std::ptrdiff_t, std::string, int>> counted;
  Fits fits;
  for (const StageRecord& record : job.run.manifest().stages) {
    const std::optional<FitId> id = fit_of(record.name);
    if (!id) continue;
    const std::string name = id->name();
    const auto place = std::ranges::find(models, id->model, &estimate::ModelOptions::name);
    const bool of_scene = place != models.end() && std::ranges::count(place->seeds, id->seed) > 0;
    if (!of_scene && std::ranges::count(by_name, name) == 0) {
      fits.left_out.push_back({name, "not in the scene"});
      continue;
    }
    const Stage stage =
        fit_stage(job, requested_fits(job.problem.scene, {id->model}, {id->seed}).front());
    if (const auto changed = job.run.changed(stage); !changed.empty())
      fits.left_out.push_back({name, fmt::format("changed since: {}", fmt::join(changed, ", "))});
    else if (!job.run.intact(record))
      fits.left_out.push_back({name, "its files changed"});
    else
      counted.emplace_back(place - models.begin(), id->model, id->seed);
  }
  std::ranges::sort(counted);
  for (const auto& [place, model, seed] : counted)
    fits.counted.push_back(requested_fits(job.problem.scene, {model}, {seed}).front());
  return fits;
}

}  // namespace fricid::workflow
