// Robot and friction as one discrete-time system: the step that evaluation, training and filters share.
#pragma once

#include <span>
#include <vector>

#include "fricid/dynamics/algorithms.hpp"
#include "fricid/dynamics/robot_model.hpp"
#include "fricid/friction/robot_friction.hpp"

namespace fricid {

/// What an identified (or true) robot is: rigid body and friction with their parameters.
struct Arm {
  dynamics::RobotModel robot;   ///< robot.pi holds the parameters in force
  friction::Friction friction;
};

/// How an Arm is stepped over one sample with torque held: `substeps` semi-implicit Euler steps
///
///     a      = M(q)^-1 (tau - h(q, v) - tau_f(q, v, z)),   load = tau
///     v'     = v + h a,   q' = q + h v',   z' = step(z; v', h),     h = dt / substeps.
///
/// One setting for all models of a scene.
struct StepOptions {
  int substeps = 8;
};

/// Steps S-batches of states of one arm (one state per lane). Owns the workspace; make one per thread.
template <class S>
class ArmStepper {
 public:
  ArmStepper(const Arm& arm, StepOptions options);

  /// Advances (q, v, z) by dt under the held torque tau; temperature [K] per joint.
  void step(std::span<const S> tau, std::span<const S> temperature, double dt, std::span<S> q,
            std::span<S> v, std::span<S> z);

  /// Friction torque at the present state.
  void friction_torque(std::span<const S> tau, std::span<const S> temperature, std::span<const S> q,
                       std::span<const S> v, std::span<const S> z, std::span<S> tau_f);

 private:
  const Arm& arm_;
  StepOptions options_;
  dynamics::Workspace<S> ws_;
  std::vector<S> pi_, theta_, tau_f_, net_, a_;
  std::vector<friction::Input<S>> in_;
};

}  // namespace fricid
