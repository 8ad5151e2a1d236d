#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include "fricid/friction/robot_friction.hpp"
#include "fricid/sim/mujoco_arm.hpp"
#include "fricid/system/transmission.hpp"

namespace fricid::sim {

/// Applies the friction of all joints in MuJoCo, computed by friction::RobotFriction. Owns the
/// friction state. Around one physics step of length h
///
///     mj_step1;  tau_f = torque(q_k, v_k, z_k);      qfrc_applied = tau - tau_f
///     mj_step2;  z_{k+1} = step(q_{k+1}, v_{k+1}, h, z_k)
///
/// so that z moves with the new velocity, as q does in semi-implicit Euler. load = tau. Friction of
/// coupled motors is computed in motor coordinates and converted to the joints (`Transmission`).
class FrictionHost {
 public:
  /// @throws UserError when the number of joints differs
  FrictionHost(const friction::Friction& friction, const MujocoArm& arm,
               const dynamics::RobotModel& robot);
  /// @param qpos, dof  addresses of the joints of `robot` in qpos and qvel (n)
  FrictionHost(const friction::Friction& friction, const dynamics::RobotModel& robot,
               std::vector<int> qpos, std::vector<int> dof);

  const std::vector<int>& dof() const { return dof_; }

  std::span<double> z() { return z_; }
  std::span<const double> z() const { return z_; }

  /// tau_f (n) [N m] at the present state of `data`, valid until the next call. Costs little where
  /// the inputs are those of the last call of `torque`, or of `step` when the torque after the step
  /// before was asked for at its inputs too: then `step` foresees it.
  /// @param tau, temperature  motor torque [N m] and temperature [K] per joint, held
  std::span<const double> torque(const mjData& data, std::span<const double> tau,
                                 std::span<const double> temperature);

  /// Moves z by h [s] with the state of `data` after the physics step, tau and temperature as held
  /// in it.
  void step(const mjData& data, std::span<const double> tau, std::span<const double> temperature,
            double h);

 private:
  /// Joints whose friction has one structure, evaluated together, each in a lane.
  struct Lanes {
    friction::RobotFriction one;  // of one joint
    int size = 0;                 // joints; further lanes repeat the last
    std::array<std::size_t, PackD::kLanes> joint{}, state{};  // of each lane: where its z begins
    std::vector<PackD> theta, z;
    friction::Input<PackD> in;
  };

  void make_lanes();
  void read(const mjData& data, std::span<const double> tau, std::span<const double> temperature);
  void gather(Lanes& lanes) const;
  void set_torque(const Lanes& lanes, PackD tau_f);
  void convert_to_joints();
  void remember(bool torque_too);
  bool is_remembered() const;
  void convert_to_motors(std::span<const double> tau);

  friction::Friction friction_;
  std::vector<int> qpos_, dof_;
  std::vector<friction::Input<double>> in_;
  std::vector<Lanes> lanes_;  // of all joints with friction; none with a law of the whole robot
  std::vector<double> z_, tau_f_;
  // inputs and states of the last call, whether tau_f_ is the torque there, and whether torques are
  // asked for where steps ended
  std::vector<friction::Input<double>> last_in_;
  std::vector<double> last_z_;
  bool knows_torque_ = false, foresees_ = false;
  Transmission motors_;
};

}  // namespace fricid::sim
