#include "fricid/data/check_file.hpp"
#include "fricid/data/dataset.hpp"
#include "fricid/data/diagnosis_file.hpp"
#include "fricid/data/estimate_file.hpp"
#include "fricid/data/fit_file.hpp"
#include "fricid/data/written_model.hpp"
#include "fricid/evaluate/bands.hpp"
#include "fricid/evaluate/compare.hpp"
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

What `fricid run` leaves. A folder is one that a run made (it has `manifest.json`), an empty or a new
one; anything else is refused. Every file is written under a temporary name, synced and renamed, so a
reader sees the old file or the new one. A stage is done again when something that it read has changed;
`manifest.json` says what each one read, by name and SHA-256. The clock is read for the manifest alone:
all other files of two equal runs have the same bytes, but for the report, which shows the manifest.

This page is written by the program's own structs: build the target `run_folder_docs` to make it anew.

| stage | reads | file | holds |
|---|---|---|---|
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
      {"", "", run.manifest(), "what was done, from what, how long it took"},
      {"data", "scene, URDF, MJCF; or logs and their contract", run.recording(recording),
       "samples: what a real log would have"},
      {"", "", run.truth(recording), "what was injected"},
      {"", "", run.excitation(), "how the trajectories were found"},
      {"", "", run.diagnosis(recording), "of logs: what is wrong with the recording"},
      {"identify MODEL_sSEED", "[robot], [identify], the model, training recordings", run.model(id),
       "the identified robot"},
      {"", "", run.fit(id), "how it was found"},
      {"evaluate", "[evaluate], models, recordings, truth, external/", run.evaluation(),
       "scores of every rollout and their summary"},
      {"", "", run.table(), "the tables of the evaluation"},
      {"", "", run.torque_table(), "motor torque along the measured motion"},
      {"", "", run.table_csv(), "one line per rollout and horizon"},
      {"", "", run.starts(), "what an external model has to roll out"},
      {"", "", run.rollout(id, recording), "its motion in open loop"},
      {"", "", run.prediction(id, recording),
       "motor torque that it predicts along the measured motion"},
      {"", "", run.band("MODEL", recording), "90 % band of its open loop"},
      {"plots", "results", run.plot("NAME", "pdf"), "and .svg, .png, and .gp to draw it anew"},
      {"video", "results, [render]", run.video("NAME"), "H.264"},
      {"report", "all of these", run.report(), "one page for a browser"}};
  std::string page = kHead;
  for (const Row& row : rows)
    page += fmt::format("| {} | {} | `{}` | {} |\n", row.stage, row.reads, run.name_of(row.file),
                        row.holds);
  page += artefact_section<workflow::Manifest>("manifest.json", "What was done.");
  page +=
      artefact_section<sim::ExcitationFile>("excitation.json", "How the trajectories were found.");
  page += artefact_section<data::DiagnosisFile>("data/RECORDING.doctor.json",
                                                "Of logs: what is wrong with the recording.");
  page += artefact_section<data::WrittenModel>(
      "models/MODEL_sSEED.json",
      "An identified robot: all that a program needs to simulate it. Numbers have full precision.");
  page += artefact_section<data::FitFile>("fit/MODEL_sSEED.json", "How a model was found.");
  page += artefact_section<evaluate::Evaluation>(
      "evaluation.json", "What the evaluation found; lists per horizon follow `horizons_s`.");
  page += signals_section<data::Dataset>("data/RECORDING.h5", "What a real log would have.");
  page += signals_section<sim::Truth>("truth/RECORDING.h5", "What was injected.");
  page += signals_section<evaluate::RolloutSignals>("rollouts/MODEL_sSEED_RECORDING.h5",
                                                    "Motion of a model in open loop.");
  page += signals_section<evaluate::PredictionSignals>("predictions/MODEL_sSEED_RECORDING.h5",
                                                       "Motor torque along the measured motion.");
  page += signals_section<evaluate::BandSignals>("bands/MODEL_RECORDING.h5",
                                                 "Where 90 % of a model's open loops lie.");
  page += signals_section<data::EstimateSignals>(
      "estimates/MODEL_sSEED_RECORDING.h5", "What `fricid estimate` wrote: the online filter.");
  page +=
      artefact_section<evaluate::Comparison>("fricid compare --json", "Runs compared, on stdout.");
  page += artefact_section<data::CheckFile>("check.json",
                                            "What `fricid check` found; with `--json` on stdout.");
  return page;
}

}  // namespace fricid
