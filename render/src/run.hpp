// What the figures of a run share.
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "fricid/data/dataset.hpp"
#include "fricid/data/hdf5.hpp"
#include "fricid/friction/robot_friction.hpp"
#include "fricid/render/figure.hpp"
#include "fricid/render/palette.hpp"

namespace fricid::render {

using data::RowMatrix;

/// The truth of the trajectory that the figures show.
struct TruthSignals {
  Eigen::VectorXd t;      ///< (T) [s]
  RowMatrix v, tau_f, z;  ///< (T, .)
  friction::Friction friction;
};

/// A run folder: its evaluation, its models, and the signals of the first held-out trajectory.
struct Run {
  std::filesystem::path folder;
  nlohmann::json evaluation;
  std::vector<RunModel> models;
  std::string trajectory;
  data::Dataset measured;
  std::optional<TruthSignals> truth;

  int n() const { return measured.n(); }
  const std::string& joint(int j) const {
    return measured.joint_names[static_cast<std::size_t>(j)];
  }
  /// Models that were fitted, that is, without the oracle.
  std::vector<RunModel> fitted() const;
  /// A model's file for the trajectory, first seed; empty when it is not there.
  std::filesystem::path file(const std::string& kind, const RunModel& model) const;
};

/// @throws UserError when the folder holds no evaluation.json, or what is there is broken
Run read_run(const std::filesystem::path& folder);

/// The injected friction in a truth file. @throws UserError naming the file
friction::Friction friction_of_truth(const data::H5Reader& file, const std::filesystem::path& path);

/// y against x in the look of a model.
Series curve(const RunModel& model, const Eigen::VectorXd& x,
             const Eigen::Ref<const Eigen::VectorXd>& y);
/// y against x in a plain colour.
Series curve(const std::string& label, const std::string& colour, const Eigen::VectorXd& x,
             const Eigen::Ref<const Eigen::VectorXd>& y, double width = 1.2);

std::vector<double> to_vector(const Eigen::Ref<const Eigen::VectorXd>& x);

}  // namespace fricid::render
