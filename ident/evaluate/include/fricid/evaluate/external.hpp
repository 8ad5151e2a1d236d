// Rollouts made by another program, scored like those of the other models.
#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "fricid/evaluate/rollout.hpp"

namespace fricid::evaluate {

/// A model of another program, represented by its rollouts.
struct ExternalModel {
  std::string name;    ///< of its folder
  std::string label;   ///< for tables and plots
  int parameters = 0;  ///< number of fitted values
  double fit_seconds = 0;
  std::vector<Rollout> rollouts;  ///< one per planned start, in that order, not yet settled
};

/// The rollouts that a model has to make, as comma-separated values with one line per start:
/// `rollout`, the name of the file to write; `trajectory`; `begin`, its sample to start from, at
/// `t` [s]; `rows` to write, that sample included; and the state to start from, q1 .. qn [rad], v1
/// .. vn [rad/s].
std::string starts_csv(std::span<const Trajectory> trajectories, std::span<const Start> starts);

/// Reads a folder: model.json, format "fricid.external/1", with label, parameters (number of fitted
/// values) and fit_seconds; and for each start ROLLOUT.h5, format "fricid.rollout/1", or
/// ROLLOUT.csv with the columns that `fricid info --csv` writes: t, q1 .. qn, v1 .. vn, tau_f1 ..
/// tau_fn, t as in the recording. tau_f may be left out: it is then not scored. After the first row
/// q and v may be NaN: the rollout has diverged there.
/// @throws UserError naming file and line when one is missing, is not of the planned rows and
///         times, or does not begin with the planned state
ExternalModel load_external_model(const std::filesystem::path& folder,
                                  std::span<const Trajectory> trajectories,
                                  std::span<const Start> starts);

}  // namespace fricid::evaluate
