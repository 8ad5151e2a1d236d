// What is reported of a fit.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "fricid/data/fit_file.hpp"
#include "fricid/data/model_file.hpp"
#include "fricid/estimate/couplings.hpp"
#include "fricid/estimate/disturbances.hpp"
#include "fricid/estimate/em/em.hpp"
#include "fricid/estimate/fault.hpp"
#include "fricid/estimate/friction/friction_fit.hpp"
#include "fricid/estimate/friction/torque_training.hpp"
#include "fricid/estimate/options/model.hpp"
#include "fricid/estimate/prepared.hpp"
#include "fricid/estimate/report.hpp"
#include "fricid/estimate/torque/arm_errors.hpp"
#include "fricid/estimate/torque/candidate.hpp"
#include "fricid/estimate/torque/folds.hpp"
#include "fricid/estimate/torque/left_torque.hpp"
#include "fricid/estimate/windows/multi_step.hpp"

namespace fricid::estimate {

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
  std::vector<std::string> weights;  ///< of joints, other than the file's; see `other_weights`
  bool frictionless = false;         ///< no joint shows friction
  std::vector<Fault> faults;         ///< why not to trust it, see `faults_of`
  std::optional<Disturbances> disturbances;  ///< none: no time is unlike the others
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
  std::vector<TightSpot> spots;               ///< (n) the same
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
/// friction coupled to another joint's speed, motion that chatters, inertia far beyond that of the
/// robot's file or below its stated armature. Of all:
/// an ill-conditioned regression, a prior that the torque contradicts, and `find_contradictions`.
std::vector<Fault> faults_of(const Prepared& prepared, const FitReport& report);

/// The file of a fit, without durations, so that equal fits have equal bytes.
data::FitFile fit_file(const FitReport& report);

}  // namespace fricid::estimate
