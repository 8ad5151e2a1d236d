#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "fricid/sim/excitation_file.hpp"
#include "fricid/sim/fourier.hpp"
#include "fricid/sim/mujoco_arm.hpp"
#include "fricid/sim/options.hpp"

namespace fricid::sim {

/// Trajectories of a scene.
struct Excitation {
  std::vector<Fourier> train, validation;
  std::vector<TrajectoryReport> reports;  ///< train, then validation
};

/// Designs all trajectories: random series with velocity amplitudes ~ k^spectrum, at rest at both
/// ends, scaled to the limits; the best of `restarts` is then improved by BOBYQA (Powell 2009) over
/// amplitude, centre and phase of each joint, by the criterion (base parameters' regressor Y_b,
/// rows weighted by 1 / effort)
///
///     d_optimal   max log det sum_t Y_b' W Y_b          condition   min cond(W^1/2 Y_b)
///
/// Every trajectory has its own random stream, so train and validation differ and results do not
/// depend on `jobs`.
/// @param known  integral of Y_b' W Y_b dt of existing data [s], which the trajectories are to
///               complement; empty: none
/// @throws UserError when no trajectory keeps all limits, naming the violated one
Excitation design_excitation(const ExcitationOptions& config, const MujocoArm& arm,
                             const dynamics::RobotModel& robot, std::uint64_t seed, int jobs,
                             const Eigen::MatrixXd& known = {});

/// log det of an information matrix; -infinity where it is not positive definite.
double log_det(const Eigen::MatrixXd& H);

/// What existing data say, in the unit in which `TrajectoryReport::log_det` counts: integrals over
/// a trajectory's period by the mean over it.
/// @param known  as of `design_excitation`
Eigen::MatrixXd per_period(const Eigen::MatrixXd& known, const ExcitationOptions& config);

/// Margins of a trajectory on a grid of `samples` times over one period.
TrajectoryReport examine(const Fourier& series, const ExcitationOptions& config,
                         const MujocoArm& arm, const dynamics::RobotModel& robot, int samples);

/// The line that says what the file of a trajectory is.
inline constexpr char kTrajectoryFormat[] = "format = \"fricid.trajectory/1\"\n";
/// A trajectory as TOML with `kTrajectoryFormat`: joints, w, q0, and a, b per joint, with the
/// formulas to evaluate them.
std::string trajectory_toml(const Fourier& series, const dynamics::RobotModel& robot);
/// The same as samples: t, then q and v of every joint.
std::string trajectory_csv(const Fourier& series, const dynamics::RobotModel& robot,
                           double rate_hz);

}  // namespace fricid::sim
