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
#include "fricid/data/problem.hpp"
#include "fricid/estimate/em/em.hpp"
#include "fricid/estimate/filter.hpp"
#include "fricid/estimate/friction/friction_fit.hpp"
#include "fricid/estimate/friction/torque_training.hpp"
#include "fricid/estimate/recording.hpp"
#include "fricid/estimate/report.hpp"
#include "fricid/estimate/rigid_body/least_squares.hpp"
#include "fricid/estimate/windows/multi_step.hpp"

namespace fricid::estimate {

/// What all conventional fits of a problem share: filtered training data and the rigid body.
/// `robot` is the scene's with a constant torque at every joint, which is identified like any other
/// parameter.
struct Prepared {
  dynamics::RobotModel robot;
  std::vector<Filtered> sequences;
  std::vector<Recording> recordings;  ///< what the gradient methods see of them
  RigidBodyFit rigid_body;
};

/// Filters the training data and identifies the rigid body with linear friction.
/// @throws UserError when the data do not fit the robot or the filter
Prepared prepare(const data::Problem& problem, std::span<const data::Dataset> train, int jobs);

/// Something that a fit to be trusted does not have.
struct Fault {
  std::string joint;   ///< empty: the whole robot
  std::string found;   ///< "R2 -249 on its own training torque"
  std::string remedy;  ///< what the user can do
};

/// "joint_a2: R2 -249 on its own training torque; record more ...".
std::string in_words(const Fault& fault);

/// How one model was fitted. `model` is usable whenever `usable()`, and best so far otherwise.
struct FitReport {
  Outcome outcome = Outcome::kFailed;
  std::string message = "fit_conventional was not called";
  data::ModelFile model;
  RigidBodyFit rigid_body;               ///< the one in the model: re-estimated with this friction
  std::vector<JointFrictionFit> joints;  ///< (n)
  std::vector<double> objective;  ///< per pass: mean over joints of residual / torque mean square
  std::vector<double> residual_rms;  ///< (n) inverse-dynamics residual, all usable rows [N m]
  std::vector<double> r2;            ///< (n) 1 - residual / torque variance on the training rows
  std::vector<Fault> faults;         ///< why not to trust it, see `faults_of`
  double seconds = 0;
  std::string method = "conventional";
  std::optional<TorqueReport> torque;         ///< of method torque, and where windows follow it
  std::optional<MultiStepReport> multi_step;  ///< of method multi_step
  std::optional<EmReport> em;                 ///< of method em

  bool has_result() const {
    return outcome == Outcome::kConverged || outcome == Outcome::kIterationLimit;
  }
  bool usable() const { return has_result() && faults.empty(); }
  std::string brief() const;  ///< one line for the terminal, faults in it
};

/// What a fit shows that one to be trusted does not: a joint whose own training torque is explained
/// by less than half (R2, the rigid body included), friction larger than the torque that was ever
/// needed or than the effort limit, a joint that stood still, a regression that says nothing.
std::vector<Fault> faults_of(const Prepared& prepared, const FitReport& report);

/// Fits one friction law of the table, per joint and alone, to what the rigid body leaves of the
/// torque, over all rows; then re-estimates the rigid body over all rows with that friction
/// removed, and the friction once more (`passes`). Joints run in parallel; the result does not
/// depend on `jobs`.
/// @throws UserError on a model name that is not a law; Stopped on Ctrl-C
FitReport fit_conventional(const data::Problem& problem, const Prepared& prepared,
                           const data::ModelConfig& config, int seed, int jobs);

/// Fits one model of a problem by its method. Whatever the method, it starts from the
/// conventional fit of its law; learned laws start from that of dahl, their networks from random
/// weights that hardly say anything. Laws of the whole robot start from random weights and the
/// rigid body that the conventional fit of coulomb_viscous leaves; windows find them trained by
/// method torque. Methods multi_step and em choose by held-out rollouts, so that they are no worse
/// there than their start; method torque by the held-out torque.
/// @param checkpoint  where method em keeps what it has reached, and goes on from
/// @throws as fit_conventional
FitReport fit_model(const data::Problem& problem, const Prepared& prepared,
                    const data::ModelConfig& config, int seed, int jobs,
                    const Checkpoint& checkpoint = {});

/// Options of training on windows and of EM as a scene words them.
MultiStepOptions multi_step_options(const data::TrainConfig& config, int seed,
                                    std::span<const Recording> recordings);
EmOptions em_options(const data::EmConfig& config, int seed, std::span<const Recording> recordings);

/// Torque that a model predicts along a measured motion, teacher forcing, at every row (T, n) [N
/// m], filtered at cutoff_hz like the `tau` of `measured`.
data::RowMatrix predict_torque(const Arm& arm, const Filtered& measured, double cutoff_hz);

/// What of a fit goes into its file: no clock reading, so that equal fits have equal bytes.
data::FitFile fit_file(const FitReport& report);

}  // namespace fricid::estimate
