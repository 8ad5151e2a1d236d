// A load that the arm carries, from logs without and with it.
#pragma once

#include <span>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "fricid/dynamics/body.hpp"
#include "fricid/dynamics/robot_model.hpp"
#include "fricid/estimate/options/rigid_body.hpp"
#include "fricid/estimate/report.hpp"
#include "fricid/signals/recording.hpp"

namespace fricid::estimate {

/// What a load is, in the axes of the frame that carries it.
struct PayloadFit {
  Outcome outcome = Outcome::kFailed;
  std::string message = "payload_least_squares was not called";

  /// (m, m c, I about the origin of the frame) as in RobotModel: of a body, and as least squares
  /// gave them.
  dynamics::Vector10 pi = dynamics::Vector10::Zero(), free = pi;
  dynamics::Vector10 standard_error = pi;  ///< of `free`
  /// What a standard error is judged against: m, |m c| and a third of the trace of I.
  dynamics::Vector10 size = pi;

  /// Mass, centre of mass and inertia about it, and their standard errors (I: symmetric).
  dynamics::Body body{0, Eigen::Vector3d::Zero(), Eigen::Matrix3d::Zero()}, body_error = body;

  std::vector<int> equations;  ///< (n) rows of the regression per joint, both logs
  Eigen::VectorXd sigma;       ///< (2 n) residual of each joint [N m], without and with the load
};

/// Solves, over the rows that `rigid_body_least_squares` uses,
///
///     tau = Y(q, v, a) pi + friction                        without the load
///     tau = Y(q, v, a) pi + Y_L(q, v, a) phi + friction'    with it
///
/// for phi, the ten parameters of the load beside the link L that carries it (Khalil, Gautier &
/// Lemoine, ICRA 2007). The arm is the same in both. Friction is each log's own, since temperature
/// changes it: Coulomb, viscous, an offset and
///
///     b sqrt(|v|) sgn(v) + mu |tau| sgn(v)
///
/// per joint, tau the motor torque by the fit of the pass before, mu ~ N(0, 0.1^2): what grows with
/// the load. The first pass is without it. By the measured torque an axis that is mostly friction
/// would be explained by itself, with mu = 1, and say nothing of the load. What of
/// the arm neither log shows stays near the nominal values, and phi does not depend on it. `pi` of
/// the result is the body nearest to phi in the metric of its covariance. A mass clearly below zero
/// is a failure: the load is in the other log. So is a torque of the arm that one more unknown, c
/// in (1 + c) Y pi with the load, finds larger or smaller there by 2 % and five standard errors,
/// and a joint whose positions n further unknowns, the columns -d(Y pi)/dq_j with the load, find
/// shifted there by 2 mrad and six standard errors: its zero is another.
/// @param frame  that carries the load; not of the base
/// @throws UserError when the frame does not move
PayloadFit payload_least_squares(const dynamics::RobotModel& robot, const dynamics::Frame& frame,
                                 std::span<const signals::Recording> without,
                                 std::span<const signals::Recording> with,
                                 const RigidBodyOptions& options);

}  // namespace fricid::estimate
