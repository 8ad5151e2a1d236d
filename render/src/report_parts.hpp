// The sections of the report.
#pragma once

#include <string>
#include <vector>

#include "fricid/data/scene.hpp"
#include "fricid/sim/excitation_file.hpp"
#include "fricid/workflow/manifest.hpp"
#include "run.hpp"

namespace fricid::render {

/// One fit of one model and its files.
struct FittedModel {
  RunModel model;
  workflow::FitId id;
  std::optional<data::FitFile> fit;
  std::optional<data::ModelFile> file;  ///< none of rollouts alone
};

/// What the report is made from.
struct Record {
  Run run;
  data::Scene scene;
  workflow::Manifest manifest;
  std::vector<sim::TrajectoryReport> trajectories;  ///< how they were excited; empty for logs
  std::vector<FittedModel> fits;                    ///< models in order, seeds in order
};

Record read_record(const workflow::RunFolder& folder, const data::Scene& scene,
                   const workflow::Manifest& manifest);

/// What the fit of a model took, mean over its seeds [s]: as the manifest has it, or as the maker
/// of an external model says; NaN where neither does.
double fit_seconds(const Record& record, const evaluate::Summary& model);

/// Something a reader must know before trusting a number.
struct Warning {
  std::string subject;  ///< a model, a joint, a file
  std::string found, meaning, remedy;
};

// report_summary.cpp
/// Three sentences from the figures: the best model, how far it is from the oracle, what fails.
std::string summary_section(const Record& record);
std::string table_section(const Record& record);
std::string video_section(const Record& record);

// report_warnings.cpp
std::vector<Warning> warnings_of(const Record& record);
std::string warning_section(const std::vector<Warning>& warnings);

// report_figures.cpp
std::string figure_section(const Record& record);
/// One plot of the folder as a numbered figure; empty when it was not drawn.
std::string plot_html(const Record& record, const std::string& name);

// report_torque.cpp
/// Torque along the measured motion: joints, regimes, drift, and the recordings' own noise.
std::string torque_section(const Record& record);

// report_models.cpp
std::string model_section(const Record& record);

// report_data.cpp
std::string data_section(const Record& record);
std::string reproduce_section(const Record& record);

/// A model's name with a dot of its colour.
std::string dotted(const RunModel& model);

/// Share of the torque's RMS that a model leaves along the measured motion, mean over joints; NaN
/// without its predictions.
double torque_left(const Run& run, const RunModel& model);

extern const char* const kReportStyle;  ///< the style sheet

}  // namespace fricid::render
