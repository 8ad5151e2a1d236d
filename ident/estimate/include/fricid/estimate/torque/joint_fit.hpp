// Fits of friction and rigid body together, of which held-out rollouts choose one.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "fricid/estimate/torque/arm_errors.hpp"
#include "fricid/estimate/torque/arm_torque_fit.hpp"
#include "fricid/estimate/torque/by_period.hpp"
#include "fricid/estimate/torque/cable.hpp"
#include "fricid/estimate/torque/candidate.hpp"
#include "fricid/estimate/torque/folds.hpp"
#include "fricid/estimate/torque/left_torque.hpp"
#include "fricid/estimate/windows/multi_step.hpp"
#include "fricid/friction/sum.hpp"

namespace fricid::estimate {

struct Prepared;

/// A log is short where less is held out [s].
inline constexpr double kFewSeconds = 10;
/// Smallest gain of a step of fits that are only compared, and of fits that may be thrown away.
inline constexpr double kPartsGain = 1e-3, kRoughGain = 1e-2;

/// What is known of an arm before its log.
struct ArmPrior {
  Arm arm;        ///< its pi is the centre of the rigid body's prior
  double sd = 0;  ///< of friction, see `FrictionPrior`
};

/// What the fits of one job share.
class JointFits {
 public:
  /// Of which rows: those that windows train on, or all.
  enum class Rows { kTraining, kAll };

  /// Friction is under the load that the linear model of least squares predicts.
  JointFits(const Prepared& prepared, const MultiStepOptions& windows, int jobs);

  /// Friction is under the torque that `arm` predicts from now on. The measured torque as load
  /// would explain its own errors: friction that grows with them lowers any residual.
  void take_load_of(const Arm& arm);

  /// Single springs longer than a bristle begin each recording from now on as far deflected as
  /// explains its torque best beside the rest of `arm`: a cable was bent before the log began, and
  /// may not slip for the whole of it.
  void take_springs_of(const Arm& arm);

  /// Sums of the same laws are pulled to a prior from now on, or no longer.
  void take_prior(std::optional<ArmPrior> prior);
  const std::optional<ArmPrior>& prior() const { return prior_; }
  /// Whether a prior stays, by the held-out torque of fits to the training rows with and without
  /// it: a few seconds speak against it only where it errs far more.
  bool keeps_prior(double with, double without) const;
  /// Whether an arm is of the laws of the prior.
  bool is_like_prior(const Arm& arm) const;

  /// Fits pull the rigid body to that of the regression from now on, as to nominal values of a
  /// prior, or no longer: on a few seconds a flexible law and all inertias together fit what is
  /// neither. Exact laws lose by it, since the regression takes what its linear friction leaves for
  /// inertia.
  void pull_to_regression(bool pull) { pulls_to_regression_ = pull; }

  /// The robot of least squares with friction at the start that the linear friction suggests
  /// (`start_sum`).
  Arm start(std::vector<friction::JointSpec> joints) const;
  /// The same with `spec` in every joint.
  Arm start(const friction::JointSpec& spec) const;
  /// The same with `lvm_sum(parts[j])` in joint j.
  Arm start(const std::vector<friction::LvmParts>& parts) const;

  /// From now on fits keep the linear viscous friction of joints at zero whose parts have none.
  void take_viscous_of(const std::vector<friction::LvmParts>& parts);

  /// Fitted to the torque. Where friction would be part of its own load by more than 0.9, what
  /// grows with the load is bounded to half of that and all is fitted again.
  ArmTorqueFit on_torque(const Arm& start, Rows rows, WaveSearch waves = WaveSearch::kGears,
                         double smallest_gain = ArmTorqueOptions{}.smallest_gain) const;
  /// Fitted to the training rows over and over, springs deflected as the arm before explains best
  /// (`take_springs_of`).
  Arm on_torque_of_springs(const Arm& start);
  struct UnderOwnLoad {
    Arm arm;
    double moved;  ///< of a joint's load at first, the most: share of it in root mean square
  };
  /// Fitted to the torque under the load that it predicts itself, over and over until that load is
  /// still, within `smallest_gain` of itself in root mean square. The load of a rough fit is off
  /// where friction is, at reversals above all, and gaps and lengths make up for it. Where a
  /// joint's torque is mostly its own friction, a fit under too little load predicts too much:
  /// loads are mixed from the last two passes so that what moves them is least (Anderson, Iterative
  /// procedures for nonlinear integral equations, J. ACM 1965), joint by joint.
  UnderOwnLoad under_own_load(const Arm& start, Rows rows,
                              double smallest_gain = ArmTorqueOptions{}.smallest_gain);
  /// Refined on open-loop windows of the training part from there, networks held.
  Candidate on_windows(const Candidate& start, std::string_view label) const;
  /// One arm per fold, fitted to the torque of what it does not leave out, from `fitted`.
  std::vector<Arm> cross_fit(const Arm& fitted) const;
  /// How far a fit to all rows may err, see `arm_errors`.
  ArmErrors errors_of(const Arm& fitted, int count, std::uint64_t seed) const;
  const std::vector<Fold>& folds() const { return folds_; }
  /// What the recordings of folds and splits are.
  const ByPeriod& periods() const { return periods_; }

  /// Mean over joints of residual / torque variance, held-out rows [1].
  double held_out_torque(const Arm& arm) const;
  /// Root mean square of the residual torque of joint j, training rows [N m].
  double residual_rms(const Arm& arm, int j) const;
  Candidate judged(std::string name, const Arm& arm, double seconds) const;

  /// Gain of `with` over `without` on the held-out torque of joint j; on where it exceeds its
  /// standard error.
  PartEvidence compare(const Arm& with, const Arm& without, int j, friction::SumPart part) const;

  /// Per joint the `strongest_cable` in the training torque that `arm` leaves; K = 0 where that
  /// gains less than a tenth.
  std::vector<Cable> promising_cables(const Arm& arm) const;

  /// Per joint whether friction of the speed that grows with the load, `part`, would explain a
  /// tenth of the training torque that `arm` leaves (`loaded_speed`).
  /// @pre part is kLoadedViscous or kLoadedStribeck
  std::vector<bool> promises(friction::SumPart part, const Arm& arm) const;

  /// Per joint the `strongest_wave` in the torque that `arm` leaves.
  std::vector<PositionWave> waves_of(const Arm& arm) const;
  /// Per joint the `tightest_spot` in the torque that `arm` leaves.
  std::vector<TightSpot> spots_of(const Arm& arm) const;
  /// Per joint the bend of the torque in what `arm` leaves of it.
  std::vector<TorqueBend> bends_of(const Arm& arm) const;

  /// Whether every recording is long enough to train on windows.
  bool has_room_for_windows() const;
  /// Whether fewer than `kFewSeconds` are held out.
  bool is_short() const;
  /// All parts of the laws in every joint that its motion can show.
  std::vector<friction::LvmParts> all_parts() const;
  /// Whether the data tell a part from the others, as `fricid check` judges: temperature where it
  /// varies, direction where the joint slides in both, the rarer one in a twentieth of its sliding
  /// at least, load where its torque varies enough (`varies_enough`).
  bool can_show(friction::SumPart part, int joint) const;
  int n() const;
  int jobs() const { return jobs_; }

 private:
  /// Of every recording, as a load.
  std::vector<RowMatrix> predicted_torques(const Arm& arm) const;
  void take_loads(std::vector<RowMatrix> loads);
  /// `sum_limits`, what `take_viscous_of` keeps at zero and, on short logs, the load corners.
  std::vector<Limit> limits_of(const Arm& arm) const;
  ArmTorqueOptions torque_options(const Arm& arm) const;
  /// Bounds of what makes friction grow with the load, in joints where |d friction / d load|
  /// exceeds `most` somewhere: by so much smaller or larger that it would be `aimed` there.
  std::vector<Limit> load_limits(const Arm& arm, double most, double aimed) const;

  const Prepared& prepared_;
  MultiStepOptions windows_;
  int jobs_;
  ByPeriod periods_;
  Split split_;
  std::vector<signals::Recording> recordings_;  // with the load
  ArmTorqueData all_, training_, held_out_;
  MotionErrors motion_errors_;
  std::vector<Fold> folds_;
  Rollouts judging_;  // held out; of long logs also the starts from rest, which are rare
  std::vector<bool> has_viscous_;   // per joint
  ArmTorqueData::Springs springs_;  // see take_springs_of
  std::optional<ArmPrior> prior_;
  bool pulls_to_regression_ = false;
  double temperature_ = 0;
  bool has_temperature_ = false;
  std::vector<bool> slides_both_ways_, load_varies_;  // per joint
};

}  // namespace fricid::estimate
