// The stage that makes the data: by simulation, or from logs.
#include <fmt/format.h>

#include <algorithm>
#include <span>
#include <string>
#include <vector>

#include "fricid/base/error.hpp"
#include "fricid/data/artefact.hpp"
#include "fricid/data/contract.hpp"
#include "fricid/data/dataset.hpp"
#include "fricid/data/diagnosis_file.hpp"
#include "fricid/data/log_part.hpp"
#include "fricid/doctor/doctor.hpp"
#include "fricid/sim/simulate.hpp"
#include "fricid/workflow/job.hpp"
#include "fricid/workflow/section.hpp"
#include "log_import.hpp"

namespace fricid::workflow {
namespace {

namespace fs = std::filesystem;
using enum Section;

constexpr Section kSimulated[] = {kName,  kSeed,       kRobot,      kFriction,
                                  kPlant, kController, kExcitation, kSensors};
constexpr Section kImported[] = {kName, kRobot, kData};

Done simulate(const scene::Problem& part, const RunFolder& out, int jobs) {
  const sim::Simulation truth = sim::simulate(part, jobs);
  Done done;
  const auto save = [&](const std::vector<data::Dataset>& sets,
                        const std::vector<sim::Truth>& truths) {
    for (std::size_t i = 0; i < sets.size(); ++i) {
      done.files.push_back(out.recording(sets[i].name));
      data::save_dataset(sets[i], done.files.back());
      done.files.push_back(out.truth(sets[i].name));
      sim::save_truth(truths[i], done.files.back());
    }
  };
  save(truth.train, truth.train_truth);
  save(truth.validation, truth.validation_truth);
  done.files.push_back(out.excitation());
  data::save(sim::ExcitationFile{truth.excitation.reports}, done.files.back());
  return done;
}

/// Files that differ, as an imported log and its source do, may have samples in common.
/// @param sets  of the logs of the scene, in their order
/// @throws UserError when some of what is judged was learnt
void refuse_learnt_samples(const scene::Problem& part, std::span<const data::Dataset> sets) {
  const std::vector<std::string>&train = part.scene.data.train,
        &judged = part.scene.data.validation;
  for (std::size_t v = 0; v < judged.size(); ++v)
    for (std::size_t t = 0; t < train.size(); ++t) {
      const data::Dataset& of = sets[train.size() + v];
      if (const int shared = data::samples_in_common(of, sets[t]); shared > 0)
        throw UserError(
            "{}: data.validation has {}, {:.3g} s of which are in {}, which is trained on; "
            "allowed: other recordings, or other parts of one",
            part.scene.name, judged[v], shared * of.dt(), train[t]);
    }
}

Done import(const scene::Problem& part, const RunFolder& out,
            const std::function<void(const std::string&)>& say) {
  const std::vector<data::Dataset> sets = logs_of_scene(part, logs_of_data(part), say);
  refuse_learnt_samples(part, sets);
  if (!part.contract_path.empty())
    std::ranges::for_each(data::meaning_in_words(data::load_contract(part.contract_path),
                                                 part.contract_path.filename().string()),
                          say);
  Done done;
  const auto findings = doctor::diagnose(sets, &part.robot);
  for (const std::string& line : doctor::to_lines(findings, sets, doctor::is_told)) say(line);
  for (std::size_t i = 0; i < sets.size(); ++i) {
    const data::Dataset& dataset = sets[i];
    done.files.push_back(out.diagnosis(dataset.name));
    data::save(doctor::diagnosis_file(findings[i], dataset), done.files.back());
  }
  for (const data::Dataset& dataset : sets) {
    done.files.push_back(out.recording(dataset.name));
    data::save_dataset(dataset, done.files.back());
  }
  say(fmt::format("import: {}: {} recordings", part.scene.name, sets.size()));
  return done;
}

}  // namespace

Stage data_stage(const Job& job) {
  Stage stage{"data", Inputs(job.run.folder()), {}};
  if (job.problem.scene.simulates()) {
    declare(stage.inputs, job.problem, kSimulated);
    stage.inputs.text("MJCF", job.mjcf);
    stage.work = [part = part_of(job.problem, kSimulated), out = job.run.folder(), jobs = job.jobs,
                  say = job.say](const RunFolder&) {
      say("simulate: " + part.scene.name);
      return simulate(part, out, jobs);
    };
  } else {
    declare(stage.inputs, job.problem, kImported);
    declare_contract(stage.inputs, job.problem);
    declare_logs(stage.inputs, job.problem, logs_of_data(job.problem));
    stage.work = [part = part_of(job.problem, kImported), out = job.run.folder(),
                  say = job.say](const RunFolder&) { return import(part, out, say); };
  }
  return stage;
}

void make_data(Job& job) {
  if (!job.run.perform(data_stage(job))) job.say("data: up to date");
}

bool data_are_sound(const Job& job) {
  std::vector<std::string> lines;
  for (const auto name : {RunFolder::training, RunFolder::validation})
    for (int i = 0;; ++i) {
      const fs::path file = job.run.folder().diagnosis(name(i));
      if (!fs::exists(file)) break;
      const auto report = data::load<data::DiagnosisFile>(file);
      for (const data::DiagnosedFinding& finding : report.findings) {
        if (!finding.misleads) continue;
        const std::string line =
            fmt::format("not to be trusted: {}: {}{}{}: {}; {}", report.data, name_of(finding.kind),
                        finding.joints.empty() ? "" : " of ", fmt::join(finding.joints, " and "),
                        finding.consequence, finding.remedy);
        if (std::ranges::count(lines, line) > 0) continue;
        lines.push_back(line);
        job.say(line);
      }
    }
  return lines.empty();
}

}  // namespace fricid::workflow
