// Robot and friction as one discrete-time system, used by evaluation, training and filters.
#pragma once

#include <span>
#include <vector>

#include "fricid/dynamics/algorithms.hpp"
#include "fricid/dynamics/robot_model.hpp"
#include "fricid/dynamics/workspace.hpp"
#include "fricid/friction/robot_friction.hpp"
#include "fricid/signals/dataset.hpp"

namespace fricid {

/// An identified or true robot: rigid body and friction with their parameters.
struct Arm {
  dynamics::RobotModel robot;  ///< robot.pi holds the rigid-body parameters
  friction::Friction friction;
};

/// How an Arm is stepped over one sample with torque held: `substeps` semi-implicit Euler steps
///
///     a  = M(q)^-1 (tau - h(q, v) - tau_f(q, v, z)),   load = tau
///     v' = v + h a,   q' = q + h v',   z' = step(z; q', v', h),     h = dt / substeps,
///
/// or, for leap = m > 1, leaps of length H = m h that replace m such steps to second order. On
/// average over m Euler steps the velocity changes at time (H - h) / 2 of the leap, so
///
///     drift   q_m = q + (H - h)/2 v,      z_m = step(z; q_m, v, (H - h)/2)
///     kick    v'  = v + H a_m,            a_m at (q_m, v + (H - h)/2 a, z_m)
///     drift   q'  = q_m + (H + h)/2 v',   z' = step(z_m; q', v', (H + h)/2).
///
/// m = 1 is the Euler step, h -> 0 symmetric splitting. The kick evaluates M and h(q, v) at the
/// first velocity and only tau_f also at the velocity in the middle: one evaluation of the dynamics
/// and two of the friction torque per leap. docs/integration.md has the measured errors. All models
/// of a scene share one setting.
struct StepOptions {
  int substeps = 8;
  int leap = 1;  ///< divides substeps
};

/// Steps a batch of states of one arm, one state per lane of S; lane k of a Pack equals the scalar
/// step to the last bit. Owns its workspace: use one per thread. Keeps a reference to the arm.
/// Instantiated for double, PackD and PackF.
template <class S>
class ArmStepper {
 public:
  /// @throws UserError when robot and friction differ in their number of joints, substeps < 1, or
  ///         leap does not divide substeps
  ArmStepper(const Arm& arm, StepOptions options);

  /// Advances (q, v, z) by dt [s] under the held torque tau [N m]; temperature [K].
  /// Sizes: tau, temperature, q, v (n), z (state_size). Does not allocate.
  void step(std::span<const S> tau, std::span<const S> temperature, double dt, std::span<S> q,
            std::span<S> v, std::span<S> z);

  /// Replaces the parameters of the arm; they may differ between lanes. pi (11 n + n_c), theta
  /// (parameter_count).
  void set_parameters(std::span<const S> pi, std::span<const S> theta);

  /// Number of leaps in one `step`.
  int leaps() const { return options_.substeps / options_.leap; }
  void leap(std::span<const S> tau, std::span<const S> temperature, double dt, std::span<S> q,
            std::span<S> v, std::span<S> z);

  /// Vector-Jacobian product of `leap` at the state before it. The adjoint (q_bar, v_bar, z_bar) of
  /// the state after is replaced by that of the state before; the parameters' is accumulated into
  /// pi_bar and theta_bar, lane by lane (an empty span is skipped). The torque is given, not
  /// differentiated. Costs about four leaps. Does not allocate.
  void leap_pullback(std::span<const S> tau, std::span<const S> temperature, double dt,
                     std::span<const S> q, std::span<const S> v, std::span<const S> z,
                     std::span<S> q_bar, std::span<S> v_bar, std::span<S> z_bar,
                     std::span<S> pi_bar, std::span<S> theta_bar);

  /// Friction torque [N m] at the present state. Does not allocate.
  void friction_torque(std::span<const S> tau, std::span<const S> temperature, std::span<const S> q,
                       std::span<const S> v, std::span<const S> z, std::span<S> tau_f);

 private:
  void set_inputs(std::span<const S> tau, std::span<const S> temperature, std::span<const S> q,
                  std::span<const S> v);
  /// Lengths of the drifts before and after the kick, and of the whole leap [s].
  struct Lengths {
    double before, after, leap;
  };
  Lengths lengths(double dt) const;
  void drift_position(double h, std::span<S> q, std::span<const S> v);
  void approach(double before, std::span<S> q, std::span<const S> v, std::span<S> z);
  void drift_pullback(double h, std::span<const S> v, std::span<const S> z, std::span<S> q_bar,
                      std::span<S> v_bar, std::span<S> z_bar, std::span<S> theta_bar);
  void acceleration(std::span<const S> tau, double ahead, std::span<const S> q,
                    std::span<const S> v, std::span<const S> z);
  void acceleration_pullback(std::span<const S> q, std::span<const S> v, std::span<const S> z,
                             std::span<const S> a, std::span<const S> a_bar, std::span<S> q_bar,
                             std::span<S> v_bar, std::span<S> v_friction_bar, std::span<S> z_bar,
                             std::span<S> pi_bar, std::span<S> theta_bar);

  const Arm& arm_;
  StepOptions options_;
  dynamics::Workspace<S> ws_;
  std::vector<S> pi_, theta_;                    // parameters in every lane
  std::vector<S> tau_f_, net_, a_, correction_;  // (n)
  std::vector<friction::Input<S>> in_;

  // of the pullback: the state within a leap and its adjoints
  std::vector<S> q_mid_, v_mid_, z_mid_, v_new_, a_lag_, a_bar_, lambda_, v_friction_bar_;
  std::vector<S> z_next_bar_, theta_unused_;
  std::vector<friction::Input<S>> in_bar_;
};

extern template class ArmStepper<double>;
extern template class ArmStepper<PackD>;
extern template class ArmStepper<PackF>;

}  // namespace fricid
