// Open-loop evaluation of identified robots on held-out recordings.
#pragma once

#include <map>
#include <span>
#include <string>
#include <vector>

#include "fricid/data/model_file.hpp"
#include "fricid/evaluate/evaluation.hpp"
#include "fricid/evaluate/external.hpp"
#include "fricid/evaluate/options.hpp"
#include "fricid/evaluate/torque_error.hpp"

namespace fricid::evaluate {

/// Input of an evaluation: models, recordings and references.
struct Contest {
  std::string scene;
  std::vector<Trajectory> trajectories;
  /// Training recordings, from which the torque errors are estimated; empty: no bands.
  std::vector<Trajectory> training;
  /// The same under the filter of `trajectories`, with accelerations, by which these are judged;
  /// empty: no recording is called unexplained.
  std::vector<Trajectory> learnt;
  /// Per model, or empty: recordings that fits of it left out in turn, from which its torque error
  /// is estimated in their place.
  std::vector<std::vector<LeftOut>> left_out;
  /// Per model, or empty: arms that its data might as well have given, for its band.
  std::vector<std::vector<Arm>> draws;
  /// Per model, or empty: intervals of its parameters, where the truth is known.
  std::vector<std::optional<ParameterIntervals>> intervals;
  /// Models to roll out. Those with is_oracle start from the true friction state.
  std::vector<data::ModelFile> models;
  /// The robot before identification: constant torques that a model adds to it count as friction.
  dynamics::RobotModel robot;
  std::vector<std::string> unconventional;  ///< names of models that are not conventional
  /// Per model, or empty: faults of its fit, one line each.
  std::vector<std::vector<std::string>> faults;
  /// Rollouts by the simulator with the true model from the true state under the measured torque,
  /// at the truth's physics step (all planned starts in their order; the first row of the report,
  /// "simulator") and at half of it (those of the first trajectory). Empty for real logs.
  std::vector<Rollout> simulator_oracle, simulator_halved;
  /// The last rows of the report. None counts as conventional, so they change no other row.
  std::vector<ExternalModel> externals;
};

/// Rolls every model out from every planned start and scores it: every model begins at the same
/// position and velocity (true ones if known, else filtered ones), its friction state
/// washed out by the measured motion before; only an oracle begins with the true friction state.
///
/// The report is the same to the last bit for any `jobs`.
/// @throws UserError naming the model or trajectory whose sizes do not agree
Evaluation evaluate(const Contest& contest, const EvaluateOptions& options, int jobs);

/// Shares and ratios from scored models, the last step of `evaluate`. `report.models`,
/// `horizons_s`, `halving` and `integration` are given; the summary and the rest of the per-horizon
/// values are filled.
void summarise(Evaluation& report, double min_headroom,
               std::span<const std::vector<double>> friction_rms);

/// The report as text: a Markdown table, comma-separated values.
std::string to_markdown(const Evaluation& report);
/// The essence as a Markdown table of five columns for a terminal: model, MSE of q at one second
/// (or the second horizon) and at the longest, error of the friction torque (without truth, of the
/// motor torque along the measured motion) and seconds of the fit.
/// @param measured_seconds  of the fits by model, see fit_seconds
std::string short_table(const Evaluation& report,
                        const std::map<std::string, double>& measured_seconds);
std::string to_csv(const Evaluation& report);
/// Torque along the measured motion, joint by joint: shares left, regimes, drift, repeatability.
/// Headings say where a joint slides: its values are forces.
std::string to_torque_markdown(const Evaluation& report, std::span<const dynamics::Joint> joints);

}  // namespace fricid::evaluate
