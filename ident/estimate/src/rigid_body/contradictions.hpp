// Where the torques of an arm's joints contradict each other by one rigid body.
#pragma once

#include <span>
#include <vector>

#include <Eigen/Core>

#include "fricid/dynamics/robot_model.hpp"
#include "fricid/estimate/fault.hpp"
#include "fricid/estimate/options/rigid_body.hpp"
#include "fricid/estimate/rigid_body/least_squares.hpp"
#include "fricid/signals/recording.hpp"

namespace fricid::estimate {

/// Factors s of the torque columns of a robot whose joints share inertial parameters:
///
///     tau_j = s_j Y_j pi + Fc_j F[sign v_j] + Fv_j v_j + offset_j + e_j.
///
/// Their common factor is that of all masses and cannot be told: the middle one is called 1.
struct TorqueScales {
  Eigen::VectorXd value;           ///< (n); empty: not found
  Eigen::VectorXd standard_error;  ///< (n)
  /// Log of the factor by which they lower the unexplained variance, in sum over the joints.
  double gain = 0;
};

/// Least squares in pi, s and friction by Gauss-Newton, rows as `rigid_body_least_squares` takes
/// them, no prior but s_j = 1 +- 0.5.
TorqueScales find_torque_scales(const dynamics::RobotModel& robot,
                                std::span<const signals::Recording> recordings,
                                const RigidBodyOptions& options);

/// What explains far more of the torque than the robot as it is given: columns that are those of
/// coupled motors and were taken for those of joints, or the other way round; else springs of
/// joints (a torque of q, sin q and cos q beside gravity), or factors of the torque of joints.
/// @param fit  of the torque as it is read; nothing is claimed where it needed a prior
std::vector<Fault> find_contradictions(const dynamics::RobotModel& robot,
                                       std::span<const signals::Recording> recordings,
                                       const RigidBodyOptions& options, const RigidBodyFit& fit);

}  // namespace fricid::estimate
