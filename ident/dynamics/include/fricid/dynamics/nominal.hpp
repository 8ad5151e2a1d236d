// Inertias that a robot's file leaves out: typical rotor inertias are guessed, a joint without any
// inertia is refused.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "fricid/dynamics/robot_model.hpp"

namespace fricid::dynamics {

/// Typical armature of each joint (n) [kg m^2]: the inertia that the effort limit accelerates to
/// the velocity limit in 0.03 s. Small and large industrial arms agree with this within a factor
/// of 4. Without limits, a third of the largest inertia of the links about the joint.
Eigen::VectorXd usual_armature(const RobotModel& robot);

/// @throws UserError naming `source`, link and joint if a joint has no inertia in any pose, the
/// other joints being free: the mass matrix is singular
void require_inertia(const RobotModel& robot, const std::string& source);

/// Joints with guessed parameters.
struct Guesses {
  std::vector<int> armature;  ///< `usual_armature`
  std::vector<int> inertia;   ///< of the moved link: a ball of its mass, or one that was mended

  bool empty() const { return armature.empty() && inertia.empty(); }
};

/// A robot with inertias that can serve as starting values and as the mean of a prior.
struct Nominal {
  RobotModel robot;
  Guesses guesses;
};

/// Guesses what the file leaves out: armatures that it does not state, and the inertia of links
/// that are points or without thickness, whose pseudo-inertia is not positive definite.
Nominal complete(const RobotModel& robot);

}  // namespace fricid::dynamics
