// Evaluations of many runs joined: the same scene with other seeds, or several scenes.
#pragma once

#include <map>
#include <span>
#include <string>
#include <vector>

#include "fricid/evaluate/evaluation.hpp"

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
  /// interval; differences between the runs cancel in the ratio.
  std::vector<double> against_convention;
  std::vector<Interval> against_convention_90;
  /// The same ratio to the model that the caller names; NaN in a scene without it.
  std::vector<double> against_named;
  std::vector<Interval> against_named_90;
  /// See Headroom, of the geometric means over the runs.
  std::vector<double> headroom_closed;
  /// Share of q inside the 90 % bands, mean over the runs that have them; empty: none has.
  std::vector<double> band_coverage;
  double friction_rollout = 0;  ///< along the rollouts, mean over the runs; NaN without truth
  std::optional<ParameterIntervals> intervals;  ///< of all runs; absent without truth

  template <class Archive>
  void visit(Archive& archive) {
    constexpr auto value = [](std::string_view unit, std::string_view meaning) {
      return any_number(unit, meaning);
    };
    archive("name", name, text("of the model"));
    archive("label", label, text("name in tables"));
    archive("is_oracle", is_oracle, flag("the true model"));
    archive("is_conventional", is_conventional, flag("one of the conventional models"));
    archive("runs", runs, number("", 1, 1e9, "number of runs with the model"));
    archive("diverged", diverged, number("", 0, 1e9, "number of diverged rollouts"));
    archive("rollouts", rollouts, number("", 0, 1e9, "number of rollouts"));
    archive("parameters", parameters, number("", 0, 1e9, "number of fitted values"));
    archive("fit_seconds", fit_seconds, value("s", "mean over the runs; null: unknown"));
    archive("friction", friction,
            value("1", "error of the friction torque, mean over the runs; null without truth"));
    archive("q_mse_geometric_mean", q_mse, value("rad^2", "per horizon, over the runs"));
    archive.pairs("interval_90", interval_90,
                  value("rad^2", "per horizon, Student t over the runs"));
    archive("against_convention", against_convention,
            value("1", "per horizon, over the best conventional model of the same run"));
    archive.pairs("against_convention_90", against_convention_90,
                  value("1", "per horizon, Student t over the runs"));
    archive("against_named", against_named,
            value("1", "per horizon, over the model `against` of the same run"));
    archive.pairs("against_named_90", against_named_90,
                  value("1", "per horizon, Student t over the runs"));
    archive("headroom_closed", headroom_closed,
            value("1", "per horizon: 0 as good as the best conventional model, 1 as the oracle"));
    archive("band_coverage", band_coverage,
            value("1",
                  "per horizon, share of q inside the 90 % bands, mean over the runs; empty: no "
                  "bands"));
    archive("friction_rollout", friction_rollout,
            value("1",
                  "error of the friction torque along the rollouts, mean over the runs; null "
                  "without truth"));
    archive.section("intervals", intervals,
                    "nominal 90 % intervals of its parameters, and how many hold the truth");
  }
};

/// All runs of one scene.
struct ComparedScene {
  std::string scene;
  int runs = 0;
  std::vector<double> horizons_s;
  std::vector<double> headroom;  ///< see Headroom, of the geometric means over the runs
  std::string against;           ///< name of the model of `against_named`; empty: none
  std::vector<ComparedModel> models;

  template <class Archive>
  void visit(Archive& archive) {
    archive("scene", scene,
            text("name of the scene; where runs of other problems have it too, with the folders"));
    archive("runs", runs, number("", 1, 1e9, "number of runs"));
    archive("horizons_s", horizons_s, number("s", 0, 1e9, "lengths of the rollouts"));
    archive("headroom", headroom, not_negative("1", "per horizon, of the means over the runs"));
    archive("against", against, text("model that the others are compared with; empty: none"));
    archive.sections("models", models, "every model that one of the runs has");
  }
};

struct Comparison {
  static constexpr std::string_view kFormat = "fricid.comparison/1";

  std::vector<ComparedScene> scenes;  ///< in the order in which the runs name them

  template <class Archive>
  void visit(Archive& archive) {
    archive.sections("scenes", scenes, "every scene, in the order of the runs");
  }
};

/// One run to be compared.
struct ComparedRun {
  std::string place;  ///< its folder, for messages
  Evaluation evaluation;
  std::map<std::string, double> fit_seconds;  ///< by model, mean over seeds [s]
  std::string problem = {};                   ///< key of robot, data and settings; empty: unknown
  std::map<std::string, std::string> fits = {};  ///< key of the settings of each fit, "lvm_s1"
};

/// Groups runs by scene: those of one name and problem, whose fits of one name have the same
/// settings. Groups of one name are told apart by their folders. A model counts in the runs that
/// have it.
/// @param against  name of a model, to whose errors those of every model are put in a ratio in the
///                 scenes that have it; empty: none
/// @throws UserError when runs of one scene differ in their horizons, or none has that model
Comparison compare_runs(std::span<const ComparedRun> runs, const std::string& against = {});

std::string to_markdown(const Comparison& comparison);

}  // namespace fricid::evaluate
