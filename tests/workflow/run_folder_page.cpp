#include "fricid/data/check_file.hpp"
#include "fricid/data/contact_file.hpp"
#include "fricid/data/dataset.hpp"
#include "fricid/data/diagnosis_file.hpp"
#include "fricid/data/estimate_file.hpp"
#include "fricid/data/fit_file.hpp"
#include "fricid/data/loop_file.hpp"
#include "fricid/data/payload_file.hpp"
#include "fricid/data/written_model.hpp"
#include "fricid/evaluate/bands.hpp"
#include "fricid/evaluate/compare.hpp"
#include "fricid/evaluate/compensation.hpp"
#include "fricid/evaluate/contact.hpp"
#include "fricid/evaluate/evaluation.hpp"
#include "fricid/evaluate/rollout.hpp"
#include "fricid/evaluate/torque_prediction.hpp"
#include "fricid/sim/excitation_file.hpp"
#include "fricid/sim/truth.hpp"
#include "fricid/workflow/manifest.hpp"
#include "fricid/workflow/run_folder.hpp"
#include "run_folder_docs.hpp"

namespace fricid {
namespace {

constexpr const char* kHead = R"(# The run folder

The files that `fricid run` writes. A run folder is new, empty, or that of an earlier run (it has
`manifest.json`); anything else is refused. Every file is written under a temporary name, synced and
renamed, so a reader sees the old file or the new one. A stage runs again when one of its inputs has
changed; `manifest.json` lists the inputs of each by name and SHA-256. Only the manifest holds times: all
other files of two equal runs have the same bytes, except the report, which shows the manifest.
`--fresh` does every stage again, also one whose record in the manifest cannot be used.

This page is generated from the program's structs: build the target `run_folder_docs` to renew it.

| stage | reads | file | holds |
|---|---|---|---|
)";

constexpr const char* kRecordings = R"(
RECORDING is train_0, validation_0, ...; of `evaluate --data FILE` the name of the file. Where a recording or result of the run has that name,
the folder of the file comes before it (of RUN/data/validation_0.h5 RUN_validation_0), and a number behind it where that is taken too.
)";

struct Row {
  std::string stage, reads;
  std::filesystem::path file;
  std::string holds;
};

}  // namespace

std::string run_folder_page() {
  using workflow::FitId, workflow::RunFolder;
  const RunFolder run(".");
  const FitId id{"MODEL", 1};
  const std::string recording = "RECORDING";
  const std::vector<Row> rows{
      {"", "", run.scene(), "the scene as run: every default filled in"},
      {"", "", run.manifest(), "stages, their inputs and outputs, and durations"},
      {"data", "scene, URDF, MJCF; or logs and their contract", run.recording(recording),
       "signals of a log, also when simulated"},
      {"", "", run.truth(recording), "true motion and injected friction"},
      {"", "", run.excitation(), "design of the trajectories"},
      {"", "", run.diagnosis(recording), "of logs: faults of the recording"},
      {"identify MODEL_sSEED", "[robot], [identify], the model, training recordings", run.model(id),
       "the identified robot"},
      {"", "", run.fit(id), "report of the fit"},
      {"evaluate", "[evaluate], models, recordings, truth, external/", run.evaluation(),
       "scores of every rollout and their summary"},
      {"", "", run.table(), "the tables of the evaluation"},
      {"", "", run.torque_table(), "motor torque along the measured motion"},
      {"", "", run.table_csv(), "one line per rollout and horizon"},
      {"", "", run.starts(), "rollouts that an external model has to make"},
      {"", "", run.rollout(id, recording), "its motion in open loop"},
      {"", "", run.prediction(id, recording),
       "motor torque that it predicts along the measured motion"},
      {"", "", run.band("MODEL", recording), "90 % band of its open loop"},
      {"payload", "[identify], [payload], training recordings, what makes the data", run.payload(),
       "the load that the recordings with it show"},
      {"", "", run.recording(workflow::RunFolder::loaded(0)), "recordings with the load"},
      {"compensate", "[compensation], models, the scene's truth", run.compensation(),
       "errors of closed loops with the models' friction fed forward"},
      {"", "", run.compensation_table(), "the same as tables"},
      {"", "", run.loop("MODEL", 0, 0), "signals of a loop, by index of path and controller"},
      {"contact", "[contact], models, the scene's truth", run.contact(),
       "errors, thresholds and delays of external torques"},
      {"", "", run.contact_table(), "the same as a table"},
      {"", "", run.pushed_loop(), "the first motion under pushes"},
      {"", "", run.external_torque("MODEL"), "the external torque found during it"},
      {"plots", "results", run.plot("NAME", "pdf"), "and .svg, .png, and .gp, the gnuplot script"},
      {"video", "results, [render]", run.video("NAME"), "H.264"},
      {"report", "all of these", run.report(), "one page for a browser"}};
  std::string page = kHead;
  for (const Row& row : rows)
    page += fmt::format("| {} | {} | `{}` | {} |\n", row.stage, row.reads, run.name_of(row.file),
                        row.holds);
  page += kRecordings;
  page += artefact_section<workflow::Manifest>("manifest.json", "The stages of the run.");
  page += artefact_section<sim::ExcitationFile>("excitation.json", "Design of the trajectories.");
  page += artefact_section<data::DiagnosisFile>("data/RECORDING.doctor.json",
                                                "Of logs: faults of the recording.");
  page += artefact_section<data::WrittenModel>(
      "models/MODEL_sSEED.json",
      "An identified robot: everything needed to simulate it. Numbers have full precision.");
  page += artefact_section<data::FitFile>("fit/MODEL_sSEED.json", "Report of a fit.");
  page += artefact_section<evaluate::Evaluation>(
      "evaluation.json", "Scores of all models; lists per horizon follow `horizons_s`.");
  page += artefact_section<data::PayloadFile>("payload.json", "A load; of `fricid payload` too.");
  page += artefact_section<evaluate::CompensationFile>(
      "compensation.json", "Closed loops with the models' friction fed forward.");
  page += artefact_section<evaluate::ContactFile>(
      "contact.json", "External torque of pushes, found with the models' friction.");
  page +=
      signals_section<data::Dataset>("data/RECORDING.h5", "Signals of a log, also when simulated.");
  page += signals_section<sim::Truth>("truth/RECORDING.h5", "True motion and injected friction.");
  page += signals_section<evaluate::RolloutSignals>("rollouts/MODEL_sSEED_RECORDING.h5",
                                                    "Motion of a model in open loop.");
  page += signals_section<evaluate::PredictionSignals>("predictions/MODEL_sSEED_RECORDING.h5",
                                                       "Motor torque along the measured motion.");
  page += signals_section<evaluate::BandSignals>("bands/MODEL_RECORDING.h5",
                                                 "90 % band of a model's open loop.");
  page += signals_section<data::EstimateSignals>("estimates/MODEL_sSEED_RECORDING.h5",
                                                 "Result of `fricid estimate`, the online filter.");
  page += signals_section<data::LoopSignals>("loops/MODEL_pathP_controllerC.h5",
                                             "The simulated arm under control.");
  page += signals_section<data::ContactSignals>(
      "contact/MODEL.h5", "External torque along a log; result of `fricid contact` too.");
  page += artefact_section<evaluate::Comparison>("fricid compare --json",
                                                 "Comparison of runs, on stdout.");
  page += artefact_section<data::CheckFile>("check.json",
                                            "Result of `fricid check`; with `--json` on stdout.");
  return page;
}

}  // namespace fricid
