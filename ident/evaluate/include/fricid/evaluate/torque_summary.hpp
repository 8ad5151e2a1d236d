// Motor torque along the measured motion: every model over its recordings and seeds.
#pragma once

#include <string>
#include <vector>

#include "fricid/evaluate/evaluation.hpp"

namespace fricid::evaluate {

/// Means over the recordings and seeds of one model.
struct TorqueSummary {
  std::string model;
  bool trusted = true;          ///< no fit of it has doubts
  bool is_static_law = false;   ///< a conventional model whose friction has no state
  std::vector<double> percent;  ///< (n) error [% of the torque's RMS]
  /// The same by regime and one step ahead, mean over joints [%]; NaN where no joint has one.
  double reversal, presliding, sliding, one_step;
  std::vector<double> drift, drift_error;  ///< (n) [N m], see TorquePrediction

  /// True when the drift of a joint exceeds three of its standard errors.
  bool drifts(std::size_t joint) const;
};

/// Models with a prediction, in the order of the evaluation.
std::vector<TorqueSummary> torque_summaries(const Evaluation& evaluation);

/// The least error of each joint among some models (n) [%]; empty without models.
std::vector<double> least_percent(const std::vector<TorqueSummary>& models);

/// Those of them that passed their own checks.
std::vector<TorqueSummary> trusted(const std::vector<TorqueSummary>& models);

/// Those of them that are static laws.
std::vector<TorqueSummary> static_laws(const std::vector<TorqueSummary>& models);

/// Number of joints at which a model errs less than `least`.
int joints_below(const TorqueSummary& model, const std::vector<double>& least);

}  // namespace fricid::evaluate
