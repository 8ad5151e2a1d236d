// Unconstrained coordinates of an arm's parameters, for training by gradients.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "fricid/estimate/options/limit.hpp"
#include "fricid/optimise/box.hpp"
#include "fricid/system/arm.hpp"

namespace fricid::estimate {

/// Which parameters move.
struct CoordinateOptions {
  bool rigid_body = true;    ///< inertial parameters, armatures and linear torques
  double rigid_rate = 0.25;  ///< step of a rigid-body coordinate relative to one of friction
  std::vector<double> torque_scale{};  ///< (n) size of the joint torques [N m]; empty: 1
  std::vector<double> stiffest{};      ///< (n) bound of friction stiffness [N m/rad]; empty: none
  std::vector<Limit> limits{};         ///< narrower bounds of parameters of friction
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
  const optimise::Box& box() const { return box_; }
  /// Index in theta of each coordinate of friction. They come first, in the order of theta.
  const std::vector<std::size_t>& friction() const { return friction_; }

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
  std::vector<std::size_t> friction_;
  int links_ = 0;
  Eigen::VectorXd start_, rate_;
  optimise::Box box_;
};

/// An arm and its coordinates as one value: a point of a search over its parameters.
class ArmPoint {
 public:
  /// `arm` as it is, beside the start of the coordinates that were made from it.
  ArmPoint(const ArmCoordinates& coordinates, const Arm& arm)
      : coordinates_(&coordinates), arm_(arm), c_(coordinates.start()) {}

  const ArmCoordinates& coordinates() const { return *coordinates_; }
  const Eigen::VectorXd& c() const { return c_; }
  const Arm& arm() const { return arm_; }

  void move_to(const Eigen::VectorXd& c) {
    c_ = c;
    coordinates_->apply(c_, arm_);
  }

  /// Gradient with respect to c from that with respect to pi and theta.
  void pull_back(const Eigen::VectorXd& pi_bar, const Eigen::VectorXd& theta_bar,
                 Eigen::VectorXd& c_bar) const {
    coordinates_->pull_back(c_, pi_bar, theta_bar, c_bar);
  }
  /// d(pi, theta)/dc, (n_pi + n_theta) x size.
  Eigen::MatrixXd jacobian() const {
    return coordinates_->jacobian(c_, arm_.robot.pi.size(),
                                  static_cast<Eigen::Index>(arm_.friction.theta.size()));
  }

 private:
  const ArmCoordinates* coordinates_;
  Arm arm_;
  Eigen::VectorXd c_;
};

}  // namespace fricid::estimate
