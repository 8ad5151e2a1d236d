#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "fricid/dynamics/algorithms.hpp"
#include "fricid/sim/options.hpp"
#include "fricid/system/transmission.hpp"

namespace fricid::sim {

/// Desired motion at one sample.
struct Reference {
  Eigen::VectorXd q, v, a;  ///< (n) [rad], [rad/s], [rad/s^2]
};

/// Joint controllers, evaluated once per sample. With e = q_ref - q, w = 2 pi bandwidth, D = diag
/// M(q):
///
///     pd_gravity       tau = g(q) + D (w^2 e + 2 zeta w e')
///     computed_torque  tau = M(q) (a_ref + w^2 e + 2 zeta w e') + h(q, v)
///     cascade          v* = v_ref + w / (2 zeta) e
///                      tau = (1 + epsilon) g(q) + 2 zeta w D (v* - v + integral (v* - v) / Ti)
///
/// g, h, M of the nominal robot; the cascade's gravity is wrong by the relative error epsilon. The
/// torque saturates at the effort limits, and the integral stops there. Coupled motors are
/// controlled in their own coordinates.
class Controller {
 public:
  Controller(const ControllerOptions& options, const dynamics::RobotModel& robot, double dt);

  /// Motor torque tau (n) [N m] for the coming sample, at the joints.
  void torque(const Reference& reference, std::span<const double> q, std::span<const double> v,
              std::span<double> tau);

  /// The part of the last torque that the errors e, e' and their integral caused, before saturation
  /// (n) [N m].
  std::span<const double> feedback() const { return feedback_; }

 private:
  void torque_at_motors(const Reference& reference, std::span<const double> q,
                        std::span<const double> v, std::span<double> tau);

  const dynamics::RobotModel& robot_;
  Transmission motors_;
  dynamics::Workspace<double> ws_;
  ControlLaw law_;
  double w_, zeta_, integral_s_, model_error_, dt_;
  std::vector<double> zero_, a_, M_, bias_, integral_, feedback_;
};

}  // namespace fricid::sim
