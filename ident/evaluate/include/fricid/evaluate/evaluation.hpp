// Result of an evaluation: scores of every rollout, their summary, and whether the errors are large
// enough above the floor to rank models. The file evaluation.json of a run folder.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "fricid/base/field.hpp"
#include "fricid/evaluate/bands.hpp"
#include "fricid/evaluate/intervals.hpp"
#include "fricid/evaluate/metrics.hpp"
#include "fricid/evaluate/repeats.hpp"
#include "fricid/evaluate/statistics.hpp"
#include "fricid/evaluate/torque_prediction.hpp"
#include "fricid/evaluate/unexplained.hpp"

namespace fricid::evaluate {

/// Scores of one rollout of one model.
struct RolloutScore {
  int trajectory = 0;  ///< index in the evaluation's list
  std::string name;    ///< of the trajectory
  double start_s = 0;
  bool diverged = false;
  HorizonErrors error;
  /// Driven by the measured motion (teacher forcing) from the start to the end of the recording;
  /// empty without truth.
  RegimeError friction;
  /// Along the rollout, that is along the motion of the model; empty without truth.
  RegimeError friction_rollout;

  template <class Archive>
  void visit(Archive& archive) {
    archive("trajectory", trajectory, text("index of the trajectory, from 0"));
    archive("name", name, text("name of the trajectory"));
    archive("start_s", start_s, number("s", 0, 1e9, "where the rollout starts"));
    archive("diverged", diverged, flag("position error beyond evaluate.diverged_rad"));
    error.visit(archive);
    friction.visit(archive, "friction_rmse");
    friction_rollout.visit(archive, "friction_rmse_rollout");
  }
};

/// All rollouts of one model and seed.
struct ModelResult {
  std::string name;
  std::string label;
  int seed = 1;
  int parameters = 0;  ///< number of fitted values
  /// Fit time of an external model as stated by its author [s]; NaN for models fitted by fricid,
  /// whose times are in the manifest.
  double stated_fit_seconds = std::numeric_limits<double>::quiet_NaN();
  std::string budget;  ///< training budget, as its model file says; empty: none in the file
  bool is_oracle = false;
  bool is_conventional = false;
  std::vector<std::string> doubts;  ///< of this seed, as in Summary
  int friction_states = 0;
  std::vector<RolloutScore> scores;
  /// Estimated on the training recordings; absent for oracles and without recordings.
  std::optional<TorqueError> torque_error;
  std::vector<TorquePrediction> torque;         ///< one per trajectory; none for oracles
  std::optional<ParameterIntervals> intervals;  ///< absent for oracles and without truth

  std::vector<Rollout> rollouts;  ///< those from the first sample, one per trajectory; own files

  template <class Archive>
  void visit(Archive& archive) {
    archive("name", name, text("name of its files"));
    archive("label", label, text("name in tables and plots"));
    archive("seed", seed, number("", 0, 1e9, "seed of the fit"));
    archive("parameters", parameters, number("", 0, 1e9, "number of fitted values"));
    archive("stated_fit_seconds", stated_fit_seconds,
            number("s", 0, 1e12,
                   "duration of the fit as stated by an external model; null: see the manifest"));
    archive("budget", budget, text("training budget; empty: none"));
    archive("is_oracle", is_oracle, flag("the true model"));
    archive("is_conventional", is_conventional, flag("one of the conventional models"));
    archive("doubts", doubts, text("why not to trust it, one line each"));
    archive("friction_states", friction_states,
            number("", 0, 1e6, "states of its friction, all joints together"));
    archive.sections("trajectories", scores, "one rollout each, by trajectory and start");
    archive.sections("torque", torque,
                     "motor torque along the measured motion, one per trajectory");
    archive.section("intervals", intervals,
                    "nominal 90 % intervals of its parameters, and how many hold the truth");
    archive.section("torque_error", torque_error,
                    "random torque disturbance that accounts for the size of its open-loop error");
  }
};

/// One model over its seeds, trajectories and starts; one value per horizon.
struct Summary {
  std::string name, label;
  bool is_oracle = false, is_conventional = false;
  /// Why not to trust it, one line each: fits that failed their own checks, joints whose held-out
  /// torque it predicts worse than its mean. Such a model counts as no best model.
  std::vector<std::string> doubts;
  int seeds = 0;
  int parameters = 0;
  double stated_fit_seconds = std::numeric_limits<double>::quiet_NaN();  ///< see ModelResult
  std::string budget;                                                    ///< of the first seed
  int diverged = 0;                                                      ///< of `rollouts`
  int rollouts = 0;
  std::vector<double> q_mse_geometric_mean, q_mse_mean, q_mse_median;
  std::vector<double> v_mse_geometric_mean;
  /// 90 % Student t interval of the geometric mean: on the logarithms of the seeds' geometric
  /// means, or of the trajectories' where there is one seed. NaN with fewer than two.
  std::vector<Interval> interval_90;
  std::string interval_over;  ///< "seeds", "trajectories" or "none"
  std::vector<double> ratio_to_oracle;
  /// log(best conventional / model) / log(best conventional / oracle): 0 as good as the best
  /// conventional model, 1 as good as the oracle. NaN without an oracle or if the headroom is not
  /// above 1.
  std::vector<double> headroom_closed;
  /// Friction torque RMSE as a share of the true RMS, mean over joints, trajectories and seeds:
  /// driven by the measured motion, whole recordings. NaN without truth.
  double friction = 0, friction_presliding = 0, friction_reversal = 0, friction_sliding = 0;
  double friction_rollout = 0;  ///< the same along the rollouts from the first sample
  /// Its seeds as an ensemble, over the rollouts from the first sample: geometric mean of the MSE
  /// of q of the ensemble's mean [rad^2], and mean coverage of its 90 % band. Empty with fewer than
  /// kFewestMembers seeds.
  std::vector<double> ensemble_q_mse, ensemble_coverage;
  /// Per horizon mean coverage and root mean square half width [rad] of the open-loop bands from
  /// the first sample, draws of all seeds together. Empty without a torque error.
  std::vector<double> band_coverage, band_half_width;
  std::optional<ParameterIntervals> intervals;  ///< of all seeds; absent without truth

  std::vector<Band> bands;  ///< one per trajectory, or none; files of their own

  template <class Archive>
  void visit(Archive& archive) {
    constexpr auto per_horizon = [](std::string_view unit, std::string_view meaning) {
      return not_negative(unit, meaning);
    };
    archive("name", name, text("of the model"));
    archive("label", label, text("name in tables and plots"));
    archive("is_oracle", is_oracle, flag("the true model"));
    archive("is_conventional", is_conventional, flag("one of the conventional models"));
    archive("doubts", doubts,
            text("why not to trust it, one line each; such a model counts as no best model"));
    archive("seeds", seeds, number("", 0, 1e9, "number of fits"));
    archive("parameters", parameters, number("", 0, 1e9, "number of fitted values"));
    archive("stated_fit_seconds", stated_fit_seconds,
            number("s", 0, 1e12, "duration of the fit as stated by an external model; else null"));
    archive("budget", budget, text("training budget of the first seed; empty: none"));
    archive("q_mse_geometric_mean", q_mse_geometric_mean,
            per_horizon("rad^2", "per horizon, over rollouts and seeds"));
    archive("q_mse_median", q_mse_median, per_horizon("rad^2", "per horizon"));
    archive("q_mse_mean", q_mse_mean, per_horizon("rad^2", "per horizon"));
    archive("v_mse_geometric_mean", v_mse_geometric_mean, per_horizon("rad^2/s^2", "per horizon"));
    archive.pairs("interval_90", interval_90,
                  per_horizon("rad^2",
                              "low and high end per horizon: 90 % Student t interval of "
                              "the geometric mean of q_mse"));
    archive("interval_over", interval_over,
            choice("seeds|trajectories|none", "what the interval is computed over"));
    archive("ratio_to_oracle", ratio_to_oracle, per_horizon("1", "per horizon"));
    archive(
        "headroom_closed", headroom_closed,
        at_most_one("1", "per horizon: 0 as good as the best conventional model, 1 as the oracle"));
    archive("diverged", diverged, number("", 0, 1e9, "number of diverged rollouts"));
    archive("rollouts", rollouts, number("", 0, 1e9, "number of rollouts"));
    archive("friction", friction,
            per_horizon("1",
                        "RMSE of the friction torque as a share of its RMS, driven by the "
                        "measured motion; null without truth"));
    archive("friction_presliding", friction_presliding, per_horizon("1", "in presliding"));
    archive("friction_reversal", friction_reversal, per_horizon("1", "at reversals"));
    archive("friction_sliding", friction_sliding, per_horizon("1", "in sliding"));
    archive("friction_rollout", friction_rollout, per_horizon("1", "along the rollouts"));
    archive("ensemble_q_mse", ensemble_q_mse,
            per_horizon("rad^2", "per horizon, of the mean of the seeds; empty: too few seeds"));
    archive("ensemble_coverage", ensemble_coverage,
            number("1", 0, 1, "per horizon, share of samples inside the seeds' 90 % band"));
    archive("band_coverage", band_coverage,
            number("1", 0, 1, "per horizon, share of samples inside the 90 % band"));
    archive("band_half_width", band_half_width,
            per_horizon("rad", "per horizon, root mean square"));
    archive.section("intervals", intervals,
                    "nominal 90 % intervals of its parameters, and how many hold the truth");
  }
};

/// Values per horizon are NaN where they do not exist (no oracle, recording too short).
struct Evaluation {
  static constexpr std::string_view kFormat = "fricid.evaluation/2";

  std::string scene;
  std::vector<double> horizons_s;  ///< full length as seconds of the longest trajectory
  std::vector<std::string> trajectories;
  std::vector<Repeats> repeats;     ///< one per trajectory
  std::vector<ModelResult> models;  ///< oracles first
  std::vector<Summary> summary;     ///< one per name, in the same order
  std::vector<double> oracle;       ///< geometric mean of q_mse [rad^2]
  /// The same between the truth and the truth at half its step, over the first recording.
  std::vector<double> halving;
  /// Without truth, where the motion repeats: half the same between a model's rollouts under the
  /// torque of one period and of the next, for the model that makes least of the difference.
  std::vector<double> repeat;
  std::vector<double> floor;        ///< the largest of the three
  std::vector<double> integration;  ///< the same between the engine's oracle and the simulator's
  std::vector<double> best_conventional;  ///< smallest geometric mean of the conventional models
  /// Best conventional / oracle, or without one / floor.
  std::vector<double> headroom;
  /// One line per horizon that cannot rank models: the error of the best conventional model is less
  /// than `min_headroom` times the floor. Empty lines for the other horizons.
  std::vector<std::string> meaningless;
  std::vector<Unexplained> unexplained;  ///< recordings that do not belong

  /// True when every horizon can rank models.
  bool meaningful() const;
  /// True when no model is in doubt, and no recording unexplained.
  bool trusted() const;

  /// @throws UserError naming `place` when the lists do not agree in length, or a name is not one:
  ///         names may become paths
  void check(const std::string& place) const;

  template <class Archive>
  void visit(Archive& archive) {
    constexpr auto mse = [](std::string_view meaning) { return not_negative("rad^2", meaning); };
    archive("scene", scene, text("name of the scene"));
    archive("horizons_s", horizons_s,
            number("s", 0, 1e9, "lengths of the rollouts; full length in seconds"));
    archive("trajectories", trajectories, text("names of the held-out recordings"));
    archive.sections("repeats", repeats,
                     "repeatability of every recording whose motion is periodic");
    archive.sections("models", models, "every model and seed, oracles first");
    archive.sections("summary", summary, "every model over its seeds, in the same order");
    archive("headroom", headroom,
            not_negative("1", "per horizon, best conventional / oracle, or without one / floor"));
    archive("oracle", oracle, mse("per horizon, geometric mean of q_mse of the oracle"));
    archive("halving", halving,
            mse("per horizon, between the truth and the truth at half its step, over the first "
                "recording"));
    archive("repeat", repeat,
            mse("per horizon, half the MSE between rollouts under the torques of two periods, "
                "smallest over the models; logs whose motion repeats"));
    archive("floor", floor, mse("per horizon, the largest of the three"));
    archive("integration", integration,
            mse("per horizon, between the engine's oracle and the simulator's"));
    archive("best_conventional", best_conventional,
            mse("per horizon, smallest geometric mean of q_mse of the conventional models"));
    archive.derived("meaningful", meaningful(), flag("every horizon can rank models"));
    archive.derived("trusted", trusted(), flag("no model has doubts, no recording is unexplained"));
    archive("meaningless", meaningless,
            text("per horizon, why it cannot rank models; empty: it can"));
    archive.sections("unexplained", unexplained,
                     "held-out torque that no trusted model explains as it does the training data");
  }
};

}  // namespace fricid::evaluate
