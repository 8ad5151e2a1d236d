// Evaluations of many runs joined: the same scene with other seeds, or several scenes.
#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "fricid/evaluate/report.hpp"

namespace fricid::evaluate {

/// One model over the runs of a scene; one value per horizon.
struct ComparedModel {
  std::string name, label;
  bool is_oracle = false, is_conventional = false;
  int runs = 0;  ///< in which the model was fitted
  int diverged = 0, rollouts = 0;
  int parameters = 0;
  double fit_seconds = 0;             ///< mean over the runs
  double friction = 0;                ///< mean over the runs; NaN without truth
  std::vector<double> q_mse;          ///< geometric mean over the runs' geometric means
  std::vector<Interval> interval_90;  ///< Student t over the runs, on logarithms
  /// Geometric mean over the runs of model / best conventional model of the same run, and its
  /// interval: what differs between runs cancels.
  std::vector<double> against_convention;
  std::vector<Interval> against_convention_90;
  /// log(best conventional / model) / log(best conventional / oracle) of the means over the runs.
  std::vector<double> headroom_closed;
};

/// All runs of one scene.
struct ComparedScene {
  std::string scene;
  int runs = 0;
  std::vector<double> horizons_s;
  std::vector<double> headroom;  ///< best conventional / oracle, means over the runs
  std::vector<ComparedModel> models;
};

/// Reads evaluation.json of every run folder and groups them by scene, in the order given. A model
/// counts in the runs that have it.
/// @throws UserError when a folder has no evaluation, or runs of one scene differ in their horizons
std::vector<ComparedScene> compare_runs(std::span<const std::filesystem::path> folders);

std::string to_markdown(std::span<const ComparedScene> scenes);
/// Format "fricid.comparison/1".
std::string to_json(std::span<const ComparedScene> scenes);

}  // namespace fricid::evaluate
