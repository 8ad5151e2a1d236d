// Conventional identification. One call per model; the rigid body is identified once.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "fricid/data/dataset.hpp"
#include "fricid/data/fit_file.hpp"
#include "fricid/data/model_file.hpp"
#include "fricid/estimate/couplings.hpp"
#include "fricid/estimate/em/em.hpp"
#include "fricid/estimate/fault.hpp"
#include "fricid/estimate/friction/friction_fit.hpp"
#include "fricid/estimate/friction/torque_training.hpp"
#include "fricid/estimate/options/model.hpp"
#include "fricid/estimate/report.hpp"
#include "fricid/estimate/rigid_body/least_squares.hpp"
#include "fricid/estimate/torque/arm_errors.hpp"
#include "fricid/estimate/torque/arm_torque_fit.hpp"
#include "fricid/estimate/torque/candidate.hpp"
#include "fricid/estimate/torque/folds.hpp"
#include "fricid/estimate/torque/left_torque.hpp"
#include "fricid/estimate/windows/multi_step.hpp"
#include "fricid/signals/recording.hpp"

namespace fricid::estimate {

/// Data shared by all fits to the same recordings: filtered training data, in motor coordinates if
/// motors are coupled (`Transmission`), and the rigid body. `robot` is the given one with guesses
/// of missing parameters (`dynamics::complete`, see `options.guesses`) and a constant torque at
/// every joint; both are identified like any other parameter.
struct Prepared {
  dynamics::RobotModel robot;
  std::vector<signals::Recording> recordings;
  RigidBodyFit rigid_body;
  /// Beside friction that grows with the load; none: the data do not show any
  std::optional<RigidBodyFit> under_load;
  RigidBodyOptions options;                 ///< of the rigid-body fit
  std::vector<Fault> contradictions;        ///< see `find_contradictions`
  std::optional<data::FittedTo> fitted_to;  ///< none: the recordings are all training data

  /// The regression with the friction that a law has.
  const RigidBodyFit& rigid_body_of(const friction::RobotFriction& law) const {
    return under_load && law.reads_load() ? *under_load : rigid_body;
  }
};

/// Filters the training data (long ones in part, see `data::training_part`) and identifies the
/// rigid body with linear friction.
/// @throws UserError when the data do not fit the robot or the filter
Prepared prepare(const dynamics::RobotModel& robot, const RigidBodyOptions& options,
                 std::span<const data::Dataset> train, int jobs);

/// The laws of a model fitted without a stretch of a recording.
struct FitWithout {
  std::string recording;  ///< name
  Stretch left_out;
  Arm arm;
};

/// How one model was fitted. `model` is usable whenever `usable()`, and best so far otherwise.
struct FitReport {
  Outcome outcome = Outcome::kFailed;
  std::string message = "fit_conventional was not called";
  std::optional<std::string> prior_left_out;  ///< why, in words
  data::ModelFile model;
  RigidBodyFit rigid_body;               ///< the one in the model: re-estimated with this friction
  std::vector<JointFrictionFit> joints;  ///< (n)
  std::vector<double> objective;  ///< per pass: mean over joints of residual / torque mean square
  std::vector<double> residual_rms;  ///< (n) inverse-dynamics residual, all usable rows [N m]
  std::vector<double> r2;            ///< (n) 1 - residual / torque variance on the training rows
  std::vector<double> sliding_r2;    ///< (n) of the rows in which the joint slides
  std::vector<double> resting_rms;   ///< (n) residual of the other rows [N m]
  std::vector<Coupling> couplings;   ///< (n)
  std::vector<Fault> faults;         ///< why not to trust it, see `faults_of`
  double seconds = 0;
  std::optional<data::FittedTo> fitted_to;  ///< none: all training data
  Method method = Method::kConventional;
  std::optional<TorqueReport> torque;         ///< of method torque, and where windows follow it
  std::optional<MultiStepReport> multi_step;  ///< of method multi_step
  std::optional<EmReport> em;                 ///< of method em
  std::vector<Candidate> candidates;          ///< of method joint; the best was taken
  std::vector<PartEvidence> parts;            ///< of model lvm
  std::vector<FitWithout> without;            ///< of method joint
  ArmErrors errors;                           ///< of method joint
  std::vector<PositionWave> waves;            ///< (n) left by a fit of method joint
  std::vector<TorqueBend> bends;              ///< (n) left by the best law of such a fit

  bool has_result() const {
    return outcome == Outcome::kConverged || outcome == Outcome::kIterationLimit;
  }
  bool usable() const { return has_result() && faults.empty(); }
  /// Why not to trust it, one sentence each; none: usable().
  std::vector<std::string> doubts() const;
  std::string brief() const;  ///< one line for the terminal
};

/// Reasons not to trust a fit. Of a joint: R2 below one half on its training torque (rigid body
/// included), no finite torque, no motion or one speed alone, negative friction or a torque of the
/// wrong sign, friction larger than the range of the torque or than the effort limit or on a bound,
/// friction coupled to another joint's speed, inertia far beyond that of the robot's file. Of all:
/// an ill-conditioned regression, a prior that the torque contradicts, and `find_contradictions`.
std::vector<Fault> faults_of(const Prepared& prepared, const FitReport& report);

/// Fits one friction law of the table, joint by joint, to the torque residual of the rigid body
/// over all rows; then re-estimates the rigid body over all rows with that friction removed, and
/// the friction once more (`passes`). Coulomb and viscous friction alone is linear: it is that of
/// the regression with the rigid body, with its standard errors, smoothed over `smoothing_speed`.
/// Joints run in parallel; the result does not depend on `jobs`.
/// @throws UserError on a model name that is not a law; Stopped on Ctrl-C
FitReport fit_conventional(const Prepared& prepared, const ModelOptions& options, int seed,
                           int jobs);

/// The conventional fits of one job: models that begin with the same one share it.
class ConventionalFits {
 public:
  explicit ConventionalFits(const Prepared& prepared) : prepared_(prepared) {}
  const Prepared& prepared() const { return prepared_; }
  /// `fit_conventional`, made at the first call.
  FitReport fit(const ModelOptions& options, int seed, int jobs);

 private:
  struct Kept {
    friction::RobotFriction law;  // of one joint
    int starts, seed;
    FitReport report;
  };
  const Prepared& prepared_;
  std::vector<Kept> kept_;
};

/// Smoothing speed of Coulomb friction: 0.01 rad/s (0.001 m/s), or three standard deviations of the
/// noise of the velocity that drives friction if that is more.
double smoothing_speed(const dynamics::RobotModel& robot,
                       std::span<const signals::Recording> recordings, double cutoff_hz, int joint);

/// Fits one model by its method. Method joint fits friction and rigid body to the torque at once
/// (`JointFits`) and continues from there by windows; of model lvm, there are several candidates,
/// strong conventional laws among them, and held-out rollouts choose. Every other method starts
/// from the conventional fit of its law; learned laws start from that of dahl, their networks from
/// random weights so small that their torque is negligible. Laws of the whole robot start from
/// random weights and the rigid body of the conventional fit of coulomb_viscous, and are trained by
/// method torque before windows. Methods multi_step and em choose the iteration with the best
/// held-out rollouts, the start included; method torque that with the least held-out torque error.
/// @param checkpoint  of method em, which saves its state there and continues from it
/// @throws as fit_conventional
FitReport fit_model(ConventionalFits& conventional, const ModelOptions& options, int seed, int jobs,
                    const optimise::Checkpoint& checkpoint = {});

/// Sizes of the joint torques in recordings: root mean square per joint (n) [N m].
std::vector<double> torque_rms(std::span<const signals::Recording> recordings);

/// Torque that a model predicts along a measured motion, teacher forcing, at every row (T, n) [N
/// m], filtered at cutoff_hz like the `filtered_tau` of `measured`. The load of friction is that
/// torque itself (`drive_under_own_load`).
RowMatrix predict_torque(const Arm& arm, const signals::Recording& measured, double cutoff_hz);

/// The file of a fit, without durations, so that equal fits have equal bytes.
data::FitFile fit_file(const FitReport& report);

}  // namespace fricid::estimate
