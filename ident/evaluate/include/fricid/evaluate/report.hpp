// What an evaluation found: scores of every rollout, their summary, and whether the benchmark means
// anything.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "fricid/evaluate/bands.hpp"
#include "fricid/evaluate/metrics.hpp"
#include "fricid/evaluate/repeats.hpp"
#include "fricid/evaluate/statistics.hpp"
#include "fricid/evaluate/torque_prediction.hpp"

namespace fricid::evaluate {

/// Scores of one rollout of one model.
struct RolloutScore {
  int trajectory = 0;
  double start_s = 0;
  bool diverged = false;
  std::vector<HorizonError> horizons;
  /// Driven by the measured motion (teacher forcing) from the start to the end of the recording;
  /// empty without truth.
  RegimeError friction;
  /// Along the rollout, which has left the true motion; empty without truth.
  RegimeError friction_rollout;
};

/// All rollouts of one model and seed.
struct ModelResult {
  std::string name;
  std::string label;
  int seed = 1;
  int parameters = 0;  ///< number of fitted values
  double fit_seconds = 0;
  std::string budget;  ///< training budget, as its model file says; empty: none in the file
  bool is_oracle = false;
  bool is_conventional = false;
  int friction_states = 0;
  std::vector<RolloutScore> scores;
  std::vector<Rollout> rollouts;         ///< those from the first sample, one per trajectory
  std::vector<TorquePrediction> torque;  ///< one per trajectory; none for oracles
  /// Found on its training recordings; absent for oracles and where there are none.
  std::optional<TorqueError> torque_error;
};

/// One model over its seeds, trajectories and starts; one value per horizon.
struct Summary {
  std::string name, label;
  bool is_oracle = false, is_conventional = false;
  int seeds = 0;
  int parameters = 0;
  double fit_seconds = 0;  ///< mean over seeds
  std::string budget;      ///< of the first seed
  int diverged = 0;        ///< rollouts, of `rollouts`
  int rollouts = 0;
  std::vector<double> q_mse_geometric_mean, q_mse_mean, q_mse_median;
  std::vector<double> v_mse_geometric_mean;
  /// 90 % Student t interval of the geometric mean: on the logarithms of the seeds' geometric
  /// means, or of the trajectories' where there is one seed. NaN with fewer than two.
  std::vector<Interval> interval_90;
  std::string interval_over;  ///< "seeds", "trajectories" or "none"
  std::vector<double> ratio_to_oracle;
  /// log(best conventional / model) / log(best conventional / oracle): 0 as good as the convention,
  /// 1 as good as physics allows. NaN without an oracle or where the headroom is not above 1.
  std::vector<double> headroom_closed;
  /// Friction torque RMSE as a share of the true RMS, mean over joints, trajectories and seeds:
  /// driven by the measured motion, whole recordings. NaN without truth.
  double friction = 0, friction_presliding = 0, friction_reversal = 0, friction_sliding = 0;
  double friction_rollout = 0;  ///< the same along the rollouts from the first sample
  /// Its seeds as an ensemble, over the rollouts from the first sample: geometric mean of the MSE
  /// of q of the ensemble's mean [rad^2], and mean coverage of its 90 % band. Empty with fewer than
  /// kFewestMembers seeds.
  std::vector<double> ensemble_q_mse, ensemble_coverage;
  /// Open-loop bands from the first sample, one per trajectory, draws of all seeds together, and
  /// per horizon their mean coverage and root mean square half width [rad]. Empty without a torque
  /// error.
  std::vector<Band> bands;
  std::vector<double> band_coverage, band_half_width;
};

/// Is a horizon's ranking more than noise? Meaningless where the best conventional model is less
/// than `min_headroom` times the floor.
struct HorizonVerdict {
  bool meaningless = false;
  std::string reason;  ///< one line, empty when all is well
};

/// Values per horizon are NaN where they do not exist (no oracle, recording too short).
struct EvaluationReport {
  std::string scene;
  std::vector<double> horizons_s;  ///< full length as seconds of the longest trajectory
  std::vector<std::string> trajectories;
  std::vector<Repeats> repeats;     ///< one per trajectory
  std::vector<ModelResult> models;  ///< oracles first
  std::vector<Summary> summary;     ///< one per name, in the same order
  std::vector<double> oracle;       ///< geometric mean of q_mse [rad^2]
  std::vector<double> halving;      ///< the same between the truth and the truth at half its step
  /// Without truth, where the motion repeats: half the same between a model's rollouts under the
  /// torque of one period and of the next, for the model that makes least of the difference.
  std::vector<double> repeat;
  std::vector<double> floor;        ///< the largest of the three
  std::vector<double> integration;  ///< the same between the engine's oracle and the simulator's
  std::vector<double> best_conventional;  ///< smallest geometric mean of the conventional models
  /// Best conventional / oracle, or without one / floor.
  std::vector<double> headroom;
  std::vector<HorizonVerdict> verdict;

  /// True when every horizon can rank models.
  bool meaningful() const;
};

}  // namespace fricid::evaluate
