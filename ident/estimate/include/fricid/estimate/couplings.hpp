// Friction that depends on the speeds of two joints.
#pragma once

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
  /// neither regression was fitted to; of all samples or of those that slide, the lesser [1].
  double share = 0;
  double r2 = 0;  ///< of the joint's torque with its own Coulomb and viscous friction
  /// Whether friction of the outer of the two joints goes with its own speed too: of what both
  /// together explain beside the one or the other, that of the motor alone is less than half.
  bool at_joint_too = false;
  /// Where friction of the joints is that of two motors instead, as of a differential, the factor
  /// of the other one, which explains what the first and the joint leave but for less than half; 0:
  /// there is none.
  double factor_of_second = 0;
};

/// The strongest coupling of every joint (n): least squares of `target` on sign and speed of the
/// joint, beside sign and speed of v_j + factor v_k, where the torque of both joints jumps as that
/// motor reverses, and while the joint slides too. Factors of either sign from a quarter to four
/// are tried, of the two joints before and behind: gears couple neighbours.
/// @param target  friction torque that the rigid body leaves, per recording (T, n) [N m]
std::vector<Coupling> find_couplings(std::span<const signals::Recording> recordings,
                                     const FrictionTorques& target);

/// Whether a coupling explains much of a joint whose torque is explained to r2 without it.
bool matters(const Coupling& coupling, double r2);

const std::string& name_of_other(const Coupling& coupling, const dynamics::RobotModel& robot);

/// The factor by which a scene declares the coupling of a joint, between the motor of the outer of
/// the two joints, which turns by q_outer - factor q_inner, and the inner joint.
double declared_factor(const Coupling& coupling, int joint);
/// The keys of a scene that declare it; empty where that is no remedy, since they are declared or
/// friction is at motors and joints, of which a model has one. Of a differential two tables.
std::string declaration_of(const Coupling& coupling, int joint, const dynamics::RobotModel& robot);

}  // namespace fricid::estimate
