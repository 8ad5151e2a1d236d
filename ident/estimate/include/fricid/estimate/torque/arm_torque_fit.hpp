// Friction of all joints and the rigid body, fitted together to the measured torque.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "fricid/estimate/coordinates.hpp"
#include "fricid/estimate/options/rigid_body.hpp"
#include "fricid/estimate/report.hpp"
#include "fricid/estimate/torque/arm_torque_data.hpp"
#include "fricid/system/arm.hpp"

namespace fricid::estimate {

/// What is known of the friction of an arm of the same type.
struct FrictionPrior {
  std::vector<double> theta;
  double sd;  ///< of each parameter, share of its size; waves over the joint angle are free
};

/// Which waves over the joint angle a fit looks for where its start has none.
enum class WaveSearch {
  kNone,
  kGears,  ///< the first of each joint at the orders of gears, further ones at any
  kAll     ///< of any order
};

struct ArmTorqueOptions {
  int iterations = 20;          ///< of Levenberg-Marquardt, before and after ripples are looked for
  double smallest_gain = 2e-4;  ///< a step that lowers the objective by a smaller share is the
                                ///< last; before ripples are looked for, 1 %
  WaveSearch waves = WaveSearch::kGears;  ///< kNone: one pass
  RigidBodyOptions rigid_body;
  Eigen::VectorXd nominal;  ///< pi about which the prior of the rigid body is
  std::optional<FrictionPrior> friction_prior;
  bool pull_static = true;  ///< static friction to that of sliding, where the data say nothing
  CoordinateOptions coordinates;
};

struct ArmTorqueFit {
  Outcome outcome = Outcome::kFailed;
  std::string message = "fit_arm_torque was not called";
  Arm arm;
  Eigen::VectorXd sigma;  ///< (n) rms of the residual [N m]
  double seconds = 0;
};

/// Minimises over all free parameters of friction and rigid body at once, by Levenberg-Marquardt on
/// coordinates (`ArmCoordinates`: physical inertia, friction within its bounds),
///
///     sum_j |Y_j pi + F[f_j(theta_j)] - tau_j|^2 / sigma_j^2  +  |pi - pi_CAD|^2_P
///
/// with F[f_j] as in `JointFrictionData`, P the prior of the rigid body or, without one, a pull
/// that decides what the data leave open; with a friction prior, |theta - theta_A|^2 in units of
/// its standard deviations beside them. Alternating between friction and rigid body would stop
/// where one explains what belongs to the other: load against gravity, above all. Ripples are
/// looked for after a first pass, in what the whole law leaves; sigma is that before each pass.
/// Deterministic; the result does not depend on `jobs`.
/// @throws Stopped on Ctrl-C
ArmTorqueFit fit_arm_torque(const ArmTorqueData& data, const Arm& start,
                            const ArmTorqueOptions& options, int jobs);

}  // namespace fricid::estimate
