// Unconstrained coordinates of an arm's parameters, for training by gradients.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "fricid/system/arm.hpp"

namespace fricid::estimate {

/// Which parameters move.
struct CoordinateOptions {
  bool rigid_body = true;    ///< inertial parameters, armatures and linear torques
  double rigid_rate = 0.25;  ///< step of a rigid-body coordinate relative to one of friction
  std::vector<double> torque_scale;  ///< (n) size of the joint torques [N m]; empty: 1
  std::vector<double> stiffest;  ///< (n) upper bound of friction's stiffness [N m/rad]; empty: none
};

/// A bijection between the physical parameters (pi, theta) of one arm and coordinates c, all of
/// them of order one, so that one step length serves all:
///
///     friction, on a logarithm  theta = exp c        friction, linear  theta = s c
///     link inertia              log-Cholesky of the pseudo-inertia (always physical)
///     armature                  Ia = exp c           linear torque     c_k = s c
///
/// s is the size of the start value or of the joint's torque. Friction stays within the bounds of
/// the law table, stiffness below `stiffest` too; what is fixed there does not move.
class ArmCoordinates {
 public:
  ArmCoordinates(const Arm& arm, const CoordinateOptions& options);

  int size() const { return static_cast<int>(start_.size()); }
  /// The arm given, within the bounds.
  const Eigen::VectorXd& start() const { return start_; }
  const Eigen::VectorXd& rate() const { return rate_; }  ///< step length of each coordinate [1]
  const Eigen::VectorXd& lower() const { return lower_; }
  const Eigen::VectorXd& upper() const { return upper_; }

  /// Parameters at c.
  void apply(const Eigen::VectorXd& c, Arm& arm) const;

  /// d(pi, theta)/dc at c, (n_pi + n_theta) x size.
  Eigen::MatrixXd jacobian(const Eigen::VectorXd& c, Eigen::Index pi_size,
                           Eigen::Index theta_size) const;

  /// Gradient with respect to c from that with respect to pi and theta, at c.
  void pull_back(const Eigen::VectorXd& c, const Eigen::VectorXd& pi_bar,
                 const Eigen::VectorXd& theta_bar, Eigen::VectorXd& c_bar) const;

 private:
  struct Scalar {
    int parameter;  // index in theta or pi
    bool in_pi, logarithmic;
    double scale;
  };
  std::vector<Scalar> scalars_;  // coordinates 0 .. scalars_.size() - 1; then ten per link
  int links_ = 0;
  Eigen::VectorXd start_, rate_, lower_, upper_;
};

}  // namespace fricid::estimate
