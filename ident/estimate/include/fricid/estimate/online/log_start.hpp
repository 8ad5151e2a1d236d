// How an arm moves as a log begins.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "fricid/signals/matrix.hpp"
#include "fricid/system/arm.hpp"

namespace fricid::estimate {

/// Motion of the motors, and the friction state of a law, at the first sample of a log.
struct LogStart {
  Eigen::VectorXd q;           ///< (n) [rad]
  Eigen::VectorXd v = {};      ///< (n) [rad/s], 0 of joints that stand; empty: all stand
  std::vector<double> z = {};  ///< (n_z); empty: zero
};

/// The state of friction as `initial_friction_state` says, from velocities over the first .1 s.
/// @param q, tau       (T, n) of the motors, without gaps [rad], [N m]
/// @param temperature  (T, n) [K], or empty for room temperature
LogStart log_start(const Arm& arm, double dt, ConstRowMatrix q, ConstRowMatrix tau,
                   ConstRowMatrix temperature);

}  // namespace fricid::estimate
