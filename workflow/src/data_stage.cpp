// The stage that makes the data: by simulation, or from logs.
#include <fmt/format.h>

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

/// Name of a log among the inputs: two logs may have one name in different folders.
std::string log_input(const std::string& recording) { return fmt::format("log of {}", recording); }

Done import_logs(const scene::Problem& part, const RunFolder& out,
                 const std::function<void(const std::string&)>& say) {
  const auto contract = data::load_contract(part.contract_path);
  std::vector<data::Dataset> sets;
  const auto import = [&](const std::vector<std::string>& logs, std::string (*name)(int)) {
    for (std::size_t i = 0; i < logs.size(); ++i) {
      const fs::path path = scene::find_log(part, logs[i]);
      const data::Dataset part_of_log =
          data::cut(data::import_log(path, contract), data::log_part(logs[i]), path.string());
      sets.push_back(
          data::of_joints(part_of_log, part.scene.joints, part.scene.robot.fix, path.string()));
      for (const std::string& warning : data::check_dataset(sets.back(), path.string()))
        say(warning);
      sets.back().name = name(static_cast<int>(i));
    }
  };
  import(part.scene.data.train, RunFolder::training);
  import(part.scene.data.validation, RunFolder::validation);

  Done done;
  for (const data::Dataset& dataset : sets) {
    const auto findings = doctor::diagnose(dataset, &part.robot);
    for (const doctor::Finding& finding : findings)
      if (doctor::is_damage(finding)) say(dataset.name + ": " + doctor::to_text(finding, dataset));
    done.files.push_back(out.diagnosis(dataset.name));
    data::save(doctor::diagnosis_file(findings, dataset), done.files.back());
  }
  for (const data::Dataset& dataset : sets) {
    done.files.push_back(out.recording(dataset.name));
    data::save_dataset(dataset, done.files.back());
  }
  say(fmt::format("import: {}: {} recordings", part.scene.name, sets.size()));
  return done;
}

void declare_logs(Inputs& inputs, const scene::Problem& problem) {
  inputs.file("contract", problem.contract_path);
  const auto add = [&](const std::vector<std::string>& logs, std::string (*name)(int)) {
    for (std::size_t i = 0; i < logs.size(); ++i)
      inputs.file(log_input(name(static_cast<int>(i))), scene::find_log(problem, logs[i]));
  };
  add(problem.scene.data.train, RunFolder::training);
  add(problem.scene.data.validation, RunFolder::validation);
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
    declare_logs(stage.inputs, job.problem);
    stage.work = [part = part_of(job.problem, kImported), out = job.run.folder(),
                  say = job.say](const RunFolder&) { return import_logs(part, out, say); };
  }
  return stage;
}

void make_data(Job& job) {
  if (!job.run.perform(data_stage(job))) job.say("data: up to date");
}

bool data_are_sound(const Job& job) {
  bool sound = true;
  for (const auto name : {RunFolder::training, RunFolder::validation})
    for (int i = 0;; ++i) {
      const fs::path file = job.run.folder().diagnosis(name(i));
      if (!fs::exists(file)) break;
      const auto report = data::load<data::DiagnosisFile>(file);
      for (const data::DiagnosedFinding& finding : report.findings) {
        if (!finding.misleads) continue;
        sound = false;
        job.say(fmt::format("not to be trusted: {}: {}{}{}: {}; {}", report.data,
                            name_of(finding.kind), finding.joints.empty() ? "" : " of ",
                            fmt::join(finding.joints, " and "), finding.consequence,
                            finding.remedy));
      }
    }
  return sound;
}

}  // namespace fricid::workflow
