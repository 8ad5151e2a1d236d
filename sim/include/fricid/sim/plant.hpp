#pragma once

#include <span>
#include <vector>

#include "fricid/data/dataset.hpp"
#include "fricid/dynamics/robot_model.hpp"
#include "fricid/friction/robot_friction.hpp"
#include "fricid/sim/friction_host.hpp"
#include "fricid/sim/mujoco_arm.hpp"
#include "fricid/sim/trace.hpp"

namespace fricid::sim {

/// The true arm: MuJoCo's rigid body, hosted friction and the linear torques c phi(q) of the robot,
///
///     M(q) a + h(q, v) + c phi(q) + tau_f = tau,
///
/// stepped by semi-implicit Euler of length arm.step() under a held motor torque. One per thread;
/// keeps references to `arm` and `robot`.
class Plant {
 public:
  Plant(const MujocoArm& arm, const dynamics::RobotModel& robot,
        const friction::Friction& friction);

  int n() const { return arm_.n(); }
  int state_size() const { return static_cast<int>(host_.z().size()); }
  double physics_step() const { return arm_.step(); }
  void set_state(const State& state);
  State state() const;

  /// Holds tau (n) [N m] and temperature (n) [K] for `steps` physics steps. Stores acceleration and
  /// friction torque at the first of them for `a` and `tau_f`.
  void hold(std::span<const double> tau, std::span<const double> temperature, int steps);

  /// Exerts a force [N], in the world, at the centre of mass of the link that a joint moves, until
  /// the next call.
  void push(int joint, const Eigen::Vector3d& force);
  /// Joint torques of the present force (n) [N m].
  Eigen::VectorXd pushed_torque() const;

  std::span<const double> a() const { return a_; }  ///< [rad/s^2] at the start of the last hold
  std::span<const double> tau_f() const { return tau_f_; }  ///< [N m] at the start of the last hold

 private:
  void physics_step(std::span<const double> tau, std::span<const double> temperature);

  const MujocoArm& arm_;
  const dynamics::RobotModel& robot_;
  MjDataPtr data_;
  FrictionHost host_;
  int pushed_ = -1;  ///< body; -1: none yet
  std::vector<double> a_, tau_f_;
};

/// Open loop of the true arm: from `initial` under the held torques tau (T, n), one row per dt.
/// @param temperature (T, n) [K]
/// @throws UserError when dt is no multiple of the physics step
Trace rollout(Plant& plant, const State& initial, const RowMatrix& tau,
              const RowMatrix& temperature, double dt);

/// Writes sample k of a trace: `state` at t_k, and the plant's `a` and `tau_f` of its last hold.
void record(const Plant& plant, const State& state, std::span<const double> tau,
            std::span<const double> temperature, int k, Trace& trace);

/// Number of physics steps in a sample. @throws UserError when `physics_step` does not divide dt
int steps_per_sample(double dt, double physics_step);

}  // namespace fricid::sim
