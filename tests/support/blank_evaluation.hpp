// An evaluation in which nothing is known yet, for tests that fill in what they need.
#pragma once

#include <limits>
#include <string>
#include <vector>

#include "fricid/evaluate/evaluation.hpp"

namespace fricid {

inline std::vector<double> unknown(std::size_t size) {
  return std::vector<double>(size, std::numeric_limits<double>::quiet_NaN());
}

inline evaluate::Evaluation blank_evaluation(const std::string& scene,
                                             std::vector<double> horizons_s,
                                             std::vector<std::string> trajectories) {
  evaluate::Evaluation evaluation;
  evaluation.scene = scene;
  evaluation.horizons_s = std::move(horizons_s);
  evaluation.trajectories = std::move(trajectories);
  evaluation.repeats.resize(evaluation.trajectories.size());
  const std::size_t horizons = evaluation.horizons_s.size();
  for (auto* values :
       {&evaluation.oracle, &evaluation.halving, &evaluation.repeat, &evaluation.floor,
        &evaluation.integration, &evaluation.best_conventional, &evaluation.headroom})
    *values = unknown(horizons);
  evaluation.meaningless.resize(horizons);
  return evaluation;
}

/// One seed of a model and its summary, at the end of both lists.
/// @param q_mse  geometric mean per horizon [rad^2]
inline void add_model(evaluate::Evaluation& evaluation, const std::string& name, bool is_oracle,
                      const std::vector<double>& q_mse) {
  evaluate::ModelResult& model = evaluation.models.emplace_back();
  model.name = model.label = name;
  model.is_oracle = is_oracle;
  model.is_conventional = !is_oracle;

  evaluate::Summary& row = evaluation.summary.emplace_back();
  row.name = row.label = name;
  row.is_oracle = is_oracle;
  row.is_conventional = !is_oracle;
  row.seeds = 1;
  row.q_mse_geometric_mean = q_mse;
  row.interval_over = "none";
  row.interval_90.assign(q_mse.size(), {unknown(1)[0], unknown(1)[0]});
  for (auto* values : {&row.q_mse_mean, &row.q_mse_median, &row.v_mse_geometric_mean,
                       &row.ratio_to_oracle, &row.headroom_closed})
    *values = unknown(q_mse.size());
  for (double* value : {&row.friction, &row.friction_presliding, &row.friction_reversal,
                        &row.friction_sliding, &row.friction_rollout})
    *value = unknown(1)[0];
}

}  // namespace fricid
