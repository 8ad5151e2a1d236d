// What changes while an arm is logged.
#pragma once

#include <span>
#include <vector>

#include "fricid/dynamics/robot_model.hpp"
#include "fricid/estimate/fault.hpp"
#include "fricid/signals/recording.hpp"
#include "rigid_body/joint_rows.hpp"

namespace fricid::estimate {

/// What may differ between pieces of a log.
enum class Change { kOffset, kFactor, kFriction, kLoad };

/// A change that no one fit of all pieces has, and what says so.
struct Changes {
  Change what = Change::kOffset;
  std::vector<Fault> faults;  ///< empty: nothing changes
};

/// The log is cut into pieces of some six seconds. Beside parameters common to all, each piece gets
/// of its own
///
///     a constant torque of each joint,
///     a factor on the torque of each joint,
///     a factor on its friction, a curve over the speed, or
///     the ten inertial parameters of a load on the last link.
///
/// What leaves a joint twelve times less variance than one fit of all pieces, by a hundredth of its
/// torque or more, changes, friction by a quarter or more; of several the one that explains most.
/// @param stacked  of the recordings
Changes find_changes(const dynamics::RobotModel& robot, const StackedByJoint& stacked,
                     std::span<const signals::Recording> recordings);

/// Friction that is half as large again in some pieces of three seconds as in others, as under a
/// brake that drags: where that leaves a joint two fifths less variance. Bodies that are described
/// wrongly look so too: for logs in which nothing else was found.
std::vector<Fault> find_changing_friction(const dynamics::RobotModel& robot,
                                          const StackedByJoint& stacked,
                                          std::span<const signals::Recording> recordings);

}  // namespace fricid::estimate
