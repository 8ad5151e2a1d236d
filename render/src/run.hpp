// Data shared by the figures of a run.
#pragma once

#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "fricid/data/dataset.hpp"
#include "fricid/data/estimate_file.hpp"
#include "fricid/data/fit_file.hpp"
#include "fricid/data/model_file.hpp"
#include "fricid/data/payload_file.hpp"
#include "fricid/evaluate/bands.hpp"
#include "fricid/evaluate/compensation.hpp"
#include "fricid/evaluate/contact.hpp"
#include "fricid/evaluate/evaluation.hpp"
#include "fricid/evaluate/rollout.hpp"
#include "fricid/evaluate/torque_prediction.hpp"
#include "fricid/render/figure.hpp"
#include "fricid/render/palette.hpp"
#include "fricid/sim/truth.hpp"
#include "fricid/workflow/run_folder.hpp"

namespace fricid::render {

using data::RowMatrix;

inline constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

/// Units of a joint's signals: one that slides has m and N.
struct Units {
  const char *q = "rad", *milli_q = "mrad", *v = "rad/s", *tau = "N m", *tau_squared = "N² m²";
};

/// A run folder: its evaluation, its models, and the signals of the first held-out trajectory.
struct Run {
  workflow::RunFolder folder;
  evaluate::Evaluation evaluation;
  std::vector<RunModel> models;
  std::string trajectory;
  data::Dataset measured;
  std::optional<sim::Truth> truth;  ///< of the trajectory
  std::optional<data::PayloadFile> payload;
  std::optional<evaluate::CompensationFile> compensation;
  std::optional<evaluate::ContactFile> contact;
  std::vector<bool> slides;  ///< (n) whether a joint slides

  int n() const { return measured.n(); }
  const std::string& joint(int j) const {
    return measured.joint_names[static_cast<std::size_t>(j)];
  }
  Units units(int j) const;
  /// Name of the joint at the head of a table of angles and torques: says where it slides.
  std::string heading(int j) const;
  /// Models that were fitted, that is, without the oracle.
  std::vector<RunModel> fitted() const;
  const RunModel* model(const std::string& name) const;  ///< null without one
  /// Summary of a model over its seeds; null without one.
  const evaluate::Summary* summary(const std::string& model) const;

  // Files of a model's first seed on the trajectory; empty if the file does not exist.
  // @throws UserError when a file is damaged or longer than the trajectory
  std::optional<evaluate::RolloutSignals> rollout(const RunModel& model) const;
  std::optional<evaluate::PredictionSignals> prediction(const RunModel& model) const;
  std::optional<data::EstimateSignals> estimate(const RunModel& model) const;
  std::optional<evaluate::BandSignals> band(const RunModel& model) const;
  std::optional<data::ModelFile> model_file(const RunModel& model) const;
  std::optional<data::FitFile> fit(const RunModel& model) const;
  // The same of any seed.
  std::optional<data::ModelFile> model_file(const workflow::FitId& id) const;
  std::optional<data::FitFile> fit(const workflow::FitId& id) const;
};

/// @throws UserError when evaluation.json is missing, or a file is damaged
Run read_run(const workflow::RunFolder& folder);

/// The look of what a closed loop feeds forward: of a model, the truth or nothing.
Look look_of_loop(const Run& run, const std::string& model);

/// y against x in the look of a model.
Series curve(const RunModel& model, const Eigen::VectorXd& x,
             const Eigen::Ref<const Eigen::VectorXd>& y);
/// y against x in a plain colour.
Series curve(const std::string& label, const std::string& colour, const Eigen::VectorXd& x,
             const Eigen::Ref<const Eigen::VectorXd>& y, double width = 1.2);

std::vector<double> to_vector(const Eigen::Ref<const Eigen::VectorXd>& x);

}  // namespace fricid::render
