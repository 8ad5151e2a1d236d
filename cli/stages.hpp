// The stages of a job. Each leaves files in the run folder and is skipped when nothing changed.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "commands.hpp"
#include "fricid/data/experiment.hpp"
#include "run_folder.hpp"

namespace fricid::cli {

/// A scene in its run folder.
struct Job {
  data::Experiment experiment;
  RunFolder folder;
  int jobs;
};

/// From a scene file (the folder is `output`, by default run/NAME) or from a run folder.
/// Nothing is created before the scene is found valid. @throws UserError
Job open_job(const RunOptions& options, const CommonOptions& common);

/// data/*.h5 and truth/*.h5 by simulation, or data/*.h5 from logs.
void make_data(Job& job);

/// models/*.json and fit/*.json for the scene's models, or those named.
/// @return false when a fit failed its own health test
bool identify_models(Job& job, const std::vector<std::string>& names, const std::string& seeds);

/// rollouts/, predictions/, evaluation.json, table.md, table.csv, torque.md.
/// @return false when a horizon is meaningless
bool evaluate_models(Job& job, const std::vector<std::filesystem::path>& further_data);

/// plots/*. A missing gnuplot costs one line on stderr, not the job.
void draw_plots(Job& job);

}  // namespace fricid::cli
