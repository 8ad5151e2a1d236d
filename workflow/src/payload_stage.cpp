// The stage that finds an unknown load from recordings with it.
#include "fricid/data/artefact.hpp"
#include "fricid/sim/simulate.hpp"
#include "fricid/workflow/job.hpp"
#include "fricid/workflow/payload.hpp"
#include "fricid/workflow/recordings.hpp"
#include "fricid/workflow/section.hpp"
#include "log_import.hpp"

namespace fricid::workflow {
namespace {

using enum Section;

constexpr Section kSimulated[] = {kName,       kSeed,       kRobot,   kFriction, kPlant,
                                  kController, kExcitation, kSensors, kIdentify, kPayload};
constexpr Section kImported[] = {kName, kRobot, kIdentify, kPayload};

std::vector<data::Dataset> loaded_recordings(const scene::Problem& part, int jobs,
                                             const std::function<void(const std::string&)>& say) {
  if (!part.scene.simulates())
    return logs_of_scene(part, named(part.scene.payload.logs, RunFolder::loaded), say);
  std::vector<data::Dataset> sets = sim::simulate(scene::with_load(part), jobs).train;
  for (std::size_t i = 0; i < sets.size(); ++i)
    sets[i].name = RunFolder::loaded(static_cast<int>(i));
  return sets;
}

Done work(const scene::Problem& part, const RunFolder& visible, const RunFolder& out, int jobs,
          const std::function<void(const std::string&)>& say) {
  const Subject without{load_recordings(visible, RunFolder::training, part.scene.joints),
                        part.robot, part.scene.identify};
  const std::vector<data::Dataset> with = loaded_recordings(part, jobs, say);
  Done done;
  for (const data::Dataset& set : with) {
    done.files.push_back(out.recording(set.name));
    data::save_dataset(set, done.files.back());
  }
  done.files.push_back(out.payload());
  data::save(find_payload(without, with, part.scene.payload.frame), done.files.back());
  return done;
}

}  // namespace

Stage payload_stage(const Job& job) {
  Stage stage{"payload", Inputs(job.run.folder()), {}};
  const bool simulates = job.problem.scene.simulates();
  const std::span<const Section> sections =
      simulates ? std::span<const Section>(kSimulated) : std::span<const Section>(kImported);
  declare(stage.inputs, job.problem, sections);
  if (simulates) {
    stage.inputs.text("MJCF", job.mjcf);
  } else {
    declare_contract(stage.inputs, job.problem);
    declare_logs(stage.inputs, job.problem,
                 named(job.problem.scene.payload.logs, RunFolder::loaded));
  }
  stage.inputs.outputs_of(job.run.results_of("data"), kTrainingData);
  stage.work = [part = part_of(job.problem, sections), out = job.run.folder(), jobs = job.jobs,
                say = job.say](const RunFolder& visible) {
    return work(part, visible, out, jobs, say);
  };
  return stage;
}

bool find_load(Job& job) {
  if (!job.problem.scene.payload.wanted()) return true;
  if (!job.run.perform(payload_stage(job))) job.say("payload: up to date");
  const auto found = data::load<data::PayloadFile>(job.run.folder().payload());
  job.say("payload: " + found.message);
  for (const std::string& doubt : found.doubts) job.say("payload: not to be trusted: " + doubt);
  return found.outcome == data::Outcome::kConverged && found.doubts.empty();
}

}  // namespace fricid::workflow
