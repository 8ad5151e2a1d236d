// A base that stands otherwise than the robot's mount says.
#pragma once

#include <optional>
#include <span>

#include "fricid/dynamics/robot_model.hpp"
#include "fricid/estimate/options/rigid_body.hpp"
#include "fricid/signals/recording.hpp"
#include "rigid_body/joint_rows.hpp"

namespace fricid::estimate {

/// Gravity in another direction than that of the robot.
struct Tilt {
  Eigen::Vector3d gravity;    ///< [m/s^2] in the frame of the base
  double angle = 0;           ///< [rad] from that of the robot
  double standard_error = 0;  ///< [rad]
  double gain = 0;  ///< log of the factor by which it lowers the unexplained variance, all joints
};

/// The direction of gravity by least squares in it and in base parameters and friction of all
/// joints, by Gauss-Newton:
///
///     tau = Y(q, v, a; g) pi + G(q; pi) dg + friction + e,   dg = delta x g,   delta perpendicular
///                                                                              to g (2 unknowns)
///
/// with G the torque of gravity by its direction. It is believed where it leaves a joint a tenth
/// less variance and is off by 20 mrad and six standard errors (jackknife). About the only axis of
/// an arm of parallel axes it is the zero of the first joint; across it, nothing shows it.
/// @param stacked  of the recordings under the options
std::optional<Tilt> find_tilt(const dynamics::RobotModel& robot, const StackedByJoint& stacked,
                              std::span<const signals::Recording> recordings,
                              const RigidBodyOptions& options);

}  // namespace fricid::estimate
