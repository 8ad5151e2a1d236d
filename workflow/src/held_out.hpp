// Recordings that models are evaluated on.
#pragma once

#include <filesystem>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "fricid/data/dataset.hpp"
#include "fricid/evaluate/trajectory.hpp"
#include "fricid/scene/problem.hpp"
#include "fricid/sim/simulate.hpp"
#include "fricid/workflow/job.hpp"

namespace fricid::workflow {

/// A data set of `--data`, and the name of the recording in tables and files.
struct FurtherData {
  std::filesystem::path file;
  std::string name;
};

/// The truth beside a data set of another run: RUN/data/NAME.h5, RUN/truth/NAME.h5.
std::filesystem::path truth_beside(const std::filesystem::path& dataset);

/// Folders of external/, sorted by name. @throws UserError on anything else, and on a name that is
/// taken or not allowed
std::vector<std::filesystem::path> external_folders(const RunFolder& run,
                                                    const std::vector<FitRequest>& fits);

/// Data sets with names that no recording of the run has: that of the file, else with the folder
/// before it, else numbered; such that no two files of results have one name.
std::vector<FurtherData> named_apart(const Job& job, const std::vector<FitRequest>& fits,
                                     const std::vector<std::filesystem::path>& files);

/// Held-out recordings with their truth, if known.
struct HeldOut {
  std::vector<evaluate::Trajectory> trajectories;
  std::vector<sim::Truth> truths;  ///< one per trajectory, or empty
};

/// The validation data of a run and further data. The truth beside further data counts where the
/// scene injects the same friction: the oracle would be that of another arm.
/// @param training  recordings that the models were fitted to
/// @param say       takes a line about a truth that is not used
/// @throws UserError on data that are not of the robot, that are trained on, or that no horizon
///         fits; and where only some have a truth
HeldOut load_held_out(const scene::Problem& problem, std::span<const FurtherData> further,
                      const RunFolder& folder, std::span<const data::Dataset> training,
                      const std::function<void(const std::string&)>& say);

}  // namespace fricid::workflow
