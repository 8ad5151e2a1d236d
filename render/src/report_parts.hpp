// The sections of the report.
#pragma once

#include <string>
#include <vector>

#include "fricid/scene/scene.hpp"
#include "fricid/sim/excitation_file.hpp"
#include "fricid/workflow/manifest.hpp"
#include "html.hpp"
#include "run.hpp"

namespace fricid::render {

/// One fit of one model and its files.
struct FittedModel {
  RunModel model;
  workflow::FitId id;
  std::optional<data::FitFile> fit;
  std::optional<data::ModelFile> file;  ///< empty for external models
};

/// Input of the report.
struct Record {
  Run run;
  scene::Scene scene;
  workflow::Manifest manifest;
  std::vector<sim::TrajectoryReport> trajectories;  ///< excitation design; empty for logs
  std::vector<FittedModel> fits;                    ///< models in order, seeds in order
};

Record read_record(const workflow::RunFolder& folder, const scene::Scene& scene,
                   const workflow::Manifest& manifest);

// report_summary.cpp
/// Three sentences: the best model, its distance from the oracle, failures.
Html summary_section(const Record& record);
Html table_section(const Record& record);
Html video_section(const Record& record);

// report_warnings.cpp
Html warning_section(const Record& record);

// report_figures.cpp
Html figure_section(const Record& record);
/// One plot of the folder as a numbered figure; empty if it does not exist.
Html plot_html(const Record& record, const std::string& name);

// report_torque.cpp
/// Torque along the measured motion: joints, regimes, drift, and the noise of the recordings.
Html torque_section(const Record& record);

// report_payload.cpp
/// An unknown load; empty without one.
Html payload_section(const Record& record);

// report_loops.cpp
/// Closed loops with the models' friction fed forward; empty without them.
Html compensation_section(const Record& record);
/// External torques of pushes; empty without them.
Html contact_section(const Record& record);

// report_models.cpp
Html model_section(const Record& record);

// report_data.cpp
Html data_section(const Record& record);
Html reproduce_section(const Record& record);

/// A model's name with a dot in its colour.
Html dotted(const RunModel& model);

Html report_style();  ///< the style sheet

}  // namespace fricid::render
