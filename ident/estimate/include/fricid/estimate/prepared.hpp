// Training data as every fit takes them.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "fricid/data/dataset.hpp"
#include "fricid/data/fit_file.hpp"
#include "fricid/estimate/fault.hpp"
#include "fricid/estimate/rigid_body/least_squares.hpp"
#include "fricid/friction/robot_friction.hpp"
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

/// Recordings of the motors' motion, one per log, with what repeats marked.
std::vector<signals::Recording> recordings_of(const dynamics::RobotModel& robot,
                                              std::span<const data::Dataset> logs, double cutoff_hz,
                                              int jobs);

/// Filters the training data (long ones in part, see `data::training_part`) and identifies the
/// rigid body with linear friction.
/// @throws UserError when the data do not fit the robot or the filter
Prepared prepare(const dynamics::RobotModel& robot, const RigidBodyOptions& options,
                 std::span<const data::Dataset> train, int jobs);

/// Smoothing speed of Coulomb friction: 0.01 rad/s (0.001 m/s), or three standard deviations of the
/// noise of the velocity that drives friction if that is more.
double smoothing_speed(const dynamics::RobotModel& robot,
                       std::span<const signals::Recording> recordings, double cutoff_hz, int joint);

/// Sizes of the joint torques in recordings: root mean square per joint (n) [N m].
std::vector<double> torque_rms(std::span<const signals::Recording> recordings);

}  // namespace fricid::estimate
