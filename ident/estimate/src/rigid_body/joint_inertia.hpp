// Inertia about each joint along a motion.
#pragma once

#include <Eigen/Core>
#include <span>

#include "fricid/dynamics/robot_model.hpp"
#include "fricid/signals/recording.hpp"

namespace fricid::estimate {

/// Mean of M_jj(q), armature included, over some samples of the recordings (n) [kg m^2 or kg].
Eigen::VectorXd joint_inertia(const dynamics::RobotModel& robot,
                              std::span<const signals::Recording> recordings);

}  // namespace fricid::estimate
