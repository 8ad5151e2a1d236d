// Friction that depends on the speeds of two joints.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "fricid/dynamics/robot_model.hpp"
#include "fricid/estimate/rigid_body/least_squares.hpp"
#include "fricid/signals/recording.hpp"

namespace fricid::estimate {

/// Friction of a joint that depends on v_j + factor v_k too, as in a wrist with a differential or a
/// belt, which no law of one joint can represent.
struct Coupling {
  int with = -1;      ///< k, the other joint; -1: none
  double factor = 1;  ///< of the other joint's speed
  /// Of the residual of the joint's own Coulomb and viscous friction, in stretches of the data that
  /// neither regression was fitted to [1].
  double share = 0;
  double r2 = 0;  ///< of the joint's torque with its own Coulomb and viscous friction
};

/// The strongest coupling of every joint (n): least squares of `target` on sign and speed of the
/// joint, beside sign and speed of v_j + factor v_k, where the torque jumps as that motor reverses.
/// Factors of either sign from a quarter to four are tried.
/// @param target  friction torque that the rigid body leaves, per recording (T, n) [N m]
std::vector<Coupling> find_couplings(std::span<const signals::Recording> recordings,
                                     const FrictionTorques& target);

/// Whether a coupling explains much of a joint whose torque is explained to r2 without it.
bool matters(const Coupling& coupling, double r2);

const std::string& name_of_other(const Coupling& coupling, const dynamics::RobotModel& robot);

/// The factor by which a scene declares the coupling of a joint, between the motor of the outer of
/// the two joints, which turns by q_outer - factor q_inner, and the inner joint.
double declared_factor(const Coupling& coupling, int joint);
/// The keys of a scene that declare it.
std::string declaration_of(const Coupling& coupling, int joint, const dynamics::RobotModel& robot);

/// Columns of torque that were taken for those of joints and are those of coupled motors, or the
/// other way round.
struct MisreadTorque {
  bool of_motors = true;  ///< what the columns are
  double factor = 1;      ///< by which their unexplained variance falls if they are read so [1]
};

/// Whether the rigid body with linear friction explains the torque of a robot with coupled motors
/// far better if its columns are read the other way.
/// @param fit  of the torque as it is read
std::optional<MisreadTorque> find_misread_torque(const dynamics::RobotModel& robot,
                                                 std::span<const signals::Recording> recordings,
                                                 const RigidBodyOptions& options,
                                                 const RigidBodyFit& fit);

/// What was found, and what to do about it.
std::string in_words(const MisreadTorque& misread);
std::string remedy_of(const MisreadTorque& misread);

}  // namespace fricid::estimate
