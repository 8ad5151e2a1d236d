#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "fricid/data/hdf5.hpp"
#include "fricid/film/options.hpp"
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

/// What the film calls its parts.
struct FilmWords {
  std::string motion;  ///< beside the scene's name
  std::string base;    ///< the arm that the others are compared with
  std::string torque = "friction torque";
  std::string error;  ///< distance of the tips
};

/// Content of the film of a run, read from the run folder's files only: the first held-out
/// trajectory, the first seed of each model.
struct RunFilm {
  std::string scene, description, friction;  ///< friction: the injected friction in words
  std::string trajectory;
  FilmWords words;
  Layout layout = Layout::kGhosts;
  bool enlarged_flange = false;  ///< in each picture of arms side by side
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

/// The film of the closed loop on the first path by the first controller: the arms with nothing and
/// with the friction of the best model fed forward, beside the desired motion, which is q. tau_f is
/// the true friction of the arm that is fed the truth, those of the models what they are fed.
/// Empty: the folder has no such loops. @throws UserError when a file is damaged
std::optional<RunFilm> read_compensation_film(const workflow::RunFolder& folder,
                                              const scene::Problem& problem);

/// "maxwell_slip, 10 elements, with load and ripple; viscous_power".
std::string describe(const friction::Friction& friction);

/// Joint with the largest friction torque error relative to its size; 0 without truth.
int most_telling_joint(const RunFilm& film);

}  // namespace fricid::film
