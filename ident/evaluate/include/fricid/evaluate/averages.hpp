// Averages of an evaluation over the rollouts of a model.
#pragma once

#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "fricid/evaluate/evaluation.hpp"

namespace fricid::evaluate {

/// Mean over horizons of log q_mse_geometric_mean, non-finite ones left out; infinity if all are.
/// The report calls the model with the smallest value the best.
double overall(const Summary& summary);

/// Summaries of all but the oracle, in the order of the evaluation.
std::vector<const Summary*> fitted_summaries(const Evaluation& evaluation);

/// Mean of an error over all rollouts of a model, at one horizon; NaN without a finite one.
double mean_error(const Evaluation& evaluation, const std::string& model,
                  std::vector<double> HorizonErrors::*error, std::size_t horizon);

/// Errors of one joint over the rollouts of a model.
struct JointErrors {
  double typical = 0;                ///< root of the geometric mean of the MSE [rad]
  double smallest = 0, largest = 0;  ///< root of the MSE [rad]
};
/// Over the seeds, trajectories and starts of a model, at one horizon; none where no error is
/// known.
/// @param resolution  errors below it count as it [rad]
std::optional<JointErrors> joint_errors(const Evaluation& evaluation, const std::string& model,
                                        std::size_t joint, std::size_t horizon, double resolution);

/// Mean over the recordings and seeds of a model of a list per joint (n); empty without one.
/// @param list  of a TorquePrediction
template <class List>
std::vector<double> mean_of_torque(const Evaluation& evaluation, const std::string& model,
                                   List list) {
  std::vector<double> sum;
  int count = 0;
  for (const ModelResult& result : evaluation.models) {
    if (result.name != model) continue;
    for (const TorquePrediction& torque : result.torque) {
      const std::vector<double>& own = std::invoke(list, torque);
      sum.resize(own.size(), 0);
      for (std::size_t j = 0; j < own.size(); ++j) sum[j] += own[j];
      ++count;
    }
  }
  for (double& value : sum) value /= count;
  return sum;
}

/// Share of the motor torque's RMS that a model leaves along the measured motion, mean over joints,
/// recordings and seeds; NaN without a prediction.
double torque_left(const Evaluation& evaluation, const std::string& model);

/// Seconds that the fit of a model took: as measured, or else as the maker of an external model
/// says; NaN where neither is known.
/// @param measured  by model, mean over seeds [s]
double fit_seconds(const Summary& summary, const std::map<std::string, double>& measured);

/// Indices of the one or two horizons of a short table: 1 s (without it the second of more than
/// two) and the longest.
std::vector<std::size_t> quoted_horizons(const std::vector<double>& horizons_s);

}  // namespace fricid::evaluate
