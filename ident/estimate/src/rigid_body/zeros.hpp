// Zeros of joints: what another zero makes of the torque, and logs that have one.
#pragma once

#include <span>
#include <vector>

#include "fricid/dynamics/robot_model.hpp"
#include "fricid/estimate/fault.hpp"
#include "fricid/estimate/options/rigid_body.hpp"
#include "fricid/signals/recording.hpp"
#include "rigid_body/joint_rows.hpp"

namespace fricid::estimate {

/// By how much less torque a joint needs, to first order, where the motion shows joint j by one
/// unit further than it is, a column for each j:
///
///     -d(Y(q, v, a) pi)/d(q_j)   (N x n) [N m/rad].
///
/// @param pi                       parameters of the robot; only Y pi counts
/// @param joint, sequence, sample  (N) of each row; rows of one sample follow each other
Eigen::MatrixXd torque_of_shifts(const dynamics::RobotModel& robot, const Eigen::VectorXd& pi,
                                 std::span<const int> joint, std::span<const int> sequence,
                                 std::span<const int> sample,
                                 std::span<const signals::Recording> recordings);

/// Joints whose zero is not the same in all logs.
struct OtherZeros {
  std::vector<Fault> faults;  ///< one per joint; empty: none
  StackedByJoint mended;      ///< the logs with one zero
};

/// Beside parameters common to all logs each log in turn gets friction (Fc, Fv) and positions (n)
/// of its own. These are believed where they leave a joint a tenth less variance, and are 5 mrad
/// (5 mm) and six standard errors (jackknife) off. Where gravity and motion say nothing of a
/// joint's position, as of a first vertical axis, another zero changes no torque and is not seen.
/// @param stacked  of the recordings under the options
OtherZeros find_other_zeros(const dynamics::RobotModel& robot, const StackedByJoint& stacked,
                            std::span<const signals::Recording> recordings,
                            const RigidBodyOptions& options);

}  // namespace fricid::estimate
