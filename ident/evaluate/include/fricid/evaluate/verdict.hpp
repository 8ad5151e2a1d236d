// The verdict on a run: the best model, failures, and the trust in each joint.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "fricid/data/fit_file.hpp"
#include "fricid/evaluate/evaluation.hpp"

namespace fricid::evaluate {

/// The name of a model in sentences: its label, or without one its name.
const std::string& label_of(const Summary& summary);

/// Fitted models that nothing speaks against, in the order of the evaluation.
std::vector<const Summary*> trusted_summaries(const Evaluation& evaluation);

/// The trusted model with the least `overall` error, the first of equals; null without one.
const Summary* best_model(const Evaluation& evaluation);

/// Trusted models, each label once, whose MSE is more than 5 % below that of `best` at some
/// horizon.
std::vector<const Summary*> better_at_a_horizon(const Evaluation& evaluation, const Summary& best);

/// The fitted model with a band and the least error at the longest horizon; null without one.
const Summary* best_with_band(const Evaluation& evaluation);

/// Failures of a run.
struct Failures {
  std::vector<const Summary*> diverging;  ///< fitted models with rollouts that diverged
  int unusable_fits = 0;
  int limited_fits = 0;                ///< stopped at the limit of iterations
  int at_bound = 0;                    ///< parameters of all fits that ended on a bound
  std::vector<double> blind_horizons;  ///< horizons that cannot rank models [s]
};
Failures failures_of(const Evaluation& evaluation, std::span<const data::FitFile* const> fits);

/// A fit under the label of its model.
struct LabelledFit {
  std::string label;
  const data::FitFile* fit;
};

/// One joint over all fits.
struct JointVerdict {
  std::string joint;
  double least_r2, most_r2;  ///< of the training torque [1]; NaN: not in any fit
  /// The first fault that a fit names at the joint, and the label of its model; null: passed.
  const data::FittedFault* fault = nullptr;
  std::string model;
};
/// Joints that are in no fit are left out. Keeps pointers to the faults in `fits`.
/// @param joints  names (n)
std::vector<JointVerdict> joint_verdicts(std::span<const std::string> joints,
                                         std::span<const LabelledFit> fits);

/// True when the physically consistent value of a base parameter lies more than three standard
/// errors from its estimate.
bool is_moved_by_physics(const data::FittedBaseParameter& parameter);

}  // namespace fricid::evaluate
