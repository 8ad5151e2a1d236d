#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "fricid/data/hdf5.hpp"
#include "fricid/scene/problem.hpp"
#include "fricid/workflow/run_folder.hpp"

namespace fricid::film {

using data::RowMatrix;

/// The open loop of one model; rows as in RunFilm::t.
struct FilmModel {
  std::string name, label, colour;
  RowMatrix q;                   ///< (T, n) [rad]
  RowMatrix v;                   ///< (T, n) [rad/s]
  RowMatrix tau_f;               ///< (T, n) [N m]
  std::filesystem::path file{};  ///< of the model; may not exist
};

/// A row of the final table.
struct FilmRow {
  std::string label, colour;
  std::vector<double> mse;  ///< q_mse_geometric_mean per horizon [rad^2]; NaN: none
  bool is_oracle = false;
  bool shown = false;  ///< it is one of the film's models
};

/// Content of the film of a run, read from the run folder's files only: the first held-out
/// trajectory, the first seed of each model.
struct RunFilm {
  std::string scene, description, friction;  ///< friction: the injected friction in words
  std::string trajectory;
  std::vector<std::string> joint_names;
  Eigen::VectorXd t;      ///< (T) [s], from 0
  RowMatrix q, v, tau_f;  ///< (T, n) the truth, or q as measured and the others empty
  RowMatrix tau;          ///< (T, n) motor torque, held over the sample that follows [N m]
  RowMatrix temperature;  ///< (T, n) [K], or empty
  std::vector<FilmModel> models;
  FilmModel oracle;              ///< q is empty if there is no oracle
  std::vector<double> horizons;  ///< [s]
  std::vector<FilmRow> table;

  bool has_truth() const { return tau_f.size() > 0; }
  int n() const { return static_cast<int>(joint_names.size()); }
  /// Row of time `at` [s], the last one at most.
  int row(double at) const;
};

/// @throws UserError when the folder holds no evaluation, or no rollout of a model of
///         problem.scene.render.models, or a file is damaged
RunFilm read_film(const workflow::RunFolder& folder, const scene::Problem& problem);

/// "maxwell_slip, 10 elements, with load and ripple; viscous_power".
std::string describe(const friction::Friction& friction);

/// Joint with the largest friction torque error relative to its size; 0 without truth.
int most_telling_joint(const RunFilm& film);

}  // namespace fricid::film
