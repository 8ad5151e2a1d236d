// Joints that lie elsewhere than the robot's file says: another arm's link lengths, a forgotten
// rpy.
#pragma once

#include <span>
#include <vector>

#include <Eigen/Core>

#include "fricid/dynamics/robot_model.hpp"
#include "fricid/estimate/options/rigid_body.hpp"
#include "fricid/signals/recording.hpp"
#include "rigid_body/joint_rows.hpp"

namespace fricid::estimate {

/// Another placement of a joint in its parent link; zero where the data do not tell.
struct MovedFrame {
  int joint = 0;
  Eigen::Vector3d by = Eigen::Vector3d::Zero();    ///< [m] in the parent's frame
  Eigen::Vector3d turn = Eigen::Vector3d::Zero();  ///< [rad] rotation vector in the file's frame
  double zero = 0;  ///< [rad or m] where it is the joint's zero alone that is another one
};

struct MovedFrames {
  std::vector<MovedFrame> joints;  ///< in the order of the arm; empty: none
  double gain = 0;  ///< log of the factor by which they lower the unexplained variance, all joints
};

/// The placements of joints behind the first by least squares in them and in base parameters and
/// friction of all joints, by Gauss-Newton:
///
///     tau = Y(q, v, a; X) pi + sum_i d(Y pi)/d(xi_i) xi_i + friction + e,   X_i <- X_i exp(xi_i)
///
/// one joint after the other, that which explains most first. They are believed where parts of the
/// data that base parameters and friction were not fitted to are explained far better, and a joint
/// moves by 10 mm or 30 mrad and four standard errors (jackknife). What inertial parameters explain
/// as well, as a shift along the axis, is left as the file has it. Where another zero of one joint
/// explains as much, it is that. The first joint's placement is the mount.
/// @param stacked  of the recordings under the options
MovedFrames find_moved_frames(const dynamics::RobotModel& robot, const StackedByJoint& stacked,
                              std::span<const signals::Recording> recordings,
                              const RigidBodyOptions& options);

}  // namespace fricid::estimate
