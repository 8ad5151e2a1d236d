// The stages of a job. Each leaves files in the run folder and is skipped when nothing changed.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "commands.hpp"
#include "fricid/data/problem.hpp"
#include "run_folder.hpp"

namespace fricid::cli {

/// A scene in its run folder.
struct Job {
  data::Problem problem;
  RunFolder folder;
  int jobs;
};

/// The problem of a scene file or of a run folder, with the seed of the options where they say one,
/// checked as far as it can be without doing any of its work: the simulated arm must be that of the
/// URDF. @throws UserError
data::Problem load_problem(const RunOptions& options);

/// @throws UserError unless `path` is the folder of an earlier run
void require_run_folder(const std::filesystem::path& path);

/// Opens or creates the run folder: `output`, by default run/NAME, or the one that is the target.
/// @throws UserError
Job open_job(data::Problem problem, const RunOptions& options, const CommonOptions& common);

/// data/*.h5 and truth/*.h5 by simulation, or data/*.h5 from logs.
void make_data(Job& job);

/// What the robot of a scene is made of, as text for keys: the content of the URDF and what MuJoCo
/// makes of the MJCF, included files and meshes with it.
std::string key_of_robot(const data::Problem& problem);

/// What the data of a scene are made of, as text for keys. @throws UserError when a log is missing
std::string key_of_data(const data::Problem& problem);

/// Stem of the files of a fit and end of its stage's name: "lugre_s1".
std::string id_of(const std::string& model, int seed);

/// The fits of a run folder, as ids.
struct Fits {
  /// Those of the scene's models and seeds and those asked for by name, where they were made from
  /// the scene, the robot and the data as they are now: in the order of the scene, then by name.
  std::vector<std::string> counted;
  std::vector<std::string> left_out;  ///< the others
};
Fits fits_of(const Job& job);

/// models/*.json and fit/*.json for the scene's models, or those named.
/// @return false when a fit failed its own health test
bool identify_models(Job& job, const std::vector<std::string>& names, const std::string& seeds);

/// rollouts/, predictions/, evaluation.json, table.md, table.csv, torque.md, starts.csv; rows also
/// of the models in external/.
/// @return false when a horizon is meaningless
bool evaluate_models(Job& job, const std::vector<std::filesystem::path>& further_data);

/// plots/*, video/*. What cannot be made (no gnuplot, nothing to draw with, disk full) is left out.
/// @return why, one line; empty when all is there
std::string draw_plots(Job& job);
/// @param shown  the job's problem, [render] changed where the user asked for it
std::string make_videos(Job& job, const data::Problem& shown, const std::string& renderer);

/// report.html, from what is there. @throws UserError when it cannot be written
void make_report(Job& job);

}  // namespace fricid::cli
