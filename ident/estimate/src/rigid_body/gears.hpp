// A joint whose gear has another ratio than was taken: it moves more, and its torque is less.
#pragma once

#include <optional>
#include <span>

#include "fricid/dynamics/robot_model.hpp"
#include "fricid/estimate/options/rigid_body.hpp"
#include "fricid/signals/recording.hpp"
#include "rigid_body/joint_rows.hpp"

namespace fricid::estimate {

struct OtherGear {
  int joint = 0;
  double ratio = 1;           ///< of the motion that it makes to the one that was logged [1]
  double standard_error = 0;  ///< of it, by the jackknife
  double gain = 0;  ///< log of the factor by which it lowers the unexplained variance, all joints
};

/// The joint j and factor s with which base parameters and friction explain most of
///
///     tau_j / s,  other tau  =  Y(q_j s, other q, ..) pi + friction + e
///
/// by Gauss-Newton from s = 1 in each joint that gains to first order. It is believed where parts
/// of the data that were not fitted to are explained far better too, s is known within 2 %
/// (standard error), and it is off by 3 % and four of them. An angle that is not zero where the
/// motor's is zero adds another zero, which is not looked for.
/// @param stacked  of the recordings under the options
std::optional<OtherGear> find_other_gear(const dynamics::RobotModel& robot,
                                         const StackedByJoint& stacked,
                                         std::span<const signals::Recording> recordings,
                                         const RigidBodyOptions& options);

}  // namespace fricid::estimate
