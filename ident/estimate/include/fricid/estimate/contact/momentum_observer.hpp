// External torque of an arm from positions and motor torques.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "fricid/dynamics/workspace.hpp"
#include "fricid/system/arm.hpp"
#include "fricid/system/driven_friction.hpp"

namespace fricid::estimate {

/// Observer of the generalised momentum p = M(q) v (De Luca & Mattone, ICRA 2005; Haddadin, De Luca
/// & Albu-Schaeffer, IEEE T-RO 33(6), 2017). With C such that dM/dt = C + C',
///
///     r = K (p - p_0 - integral (tau - tau_f + C' v - g + r) dt),     K = 2 pi bandwidth,
///
/// is the external torque through a first-order low-pass of that bandwidth. C' v is the gradient of
/// the kinetic energy. The friction tau_f is that of the arm's model, its state driven by the
/// measured motion.
///
/// In samples: momentum changes from the middle of one sample to that of the next, where the
/// velocity is the difference of two positions; all other torques are those between, at the last
/// sample but one. So r lags the low-pass by one sample.
///
/// An arm with coupled motors is observed in motor coordinates. Owns its arm; a step does not
/// allocate.
class MomentumObserver {
 public:
  /// @param z0  state of the friction at the first sample; empty: zero
  /// @throws UserError when robot and friction differ in their number of joints
  MomentumObserver(Arm arm, double dt, double bandwidth_hz, std::span<const double> z0 = {});
  MomentumObserver(const MomentumObserver&) = delete;
  MomentumObserver& operator=(const MomentumObserver&) = delete;

  /// Advances by one sample and gives r (n) [N m], valid until the next call; zero for the first
  /// two samples.
  /// @param tau          torque held since the last sample (n) [N m]
  /// @param q            positions now (n) [rad]
  /// @param temperature  (n) [K]
  /// @param seen         (n) positions that drive friction [rad]; empty: q. In the noise of an
  ///                     encoder a joint at rest would lose what it holds.
  std::span<const double> step(std::span<const double> tau, std::span<const double> q,
                               std::span<const double> temperature,
                               std::span<const double> seen = {});

  /// The same with the friction torque at the last sample (n) [N m] from elsewhere; the state of
  /// the friction follows the motion on.
  std::span<const double> step_with(std::span<const double> tau, std::span<const double> q,
                                    std::span<const double> temperature,
                                    std::span<const double> tau_f,
                                    std::span<const double> seen = {});

  /// The next sample is a first one, since samples are missing before it: r begins at zero, the
  /// state of the friction where it was. Allocates.
  void restart();

  /// Friction torque at the last sample but one (n) [N m].
  std::span<const double> friction() const { return tau_f_; }

 private:
  bool measure(std::span<const double> tau, std::span<const double> q);
  std::span<const double> advance(std::span<const double> tau, std::span<const double> q,
                                  std::span<const double> seen);
  std::span<const double> follow(std::span<const double> temperature, std::span<const double> seen);
  void momentum(std::span<const double> q, std::span<const double> v, std::span<double> p);
  void kinetic_gradient(std::span<const double> q, std::span<const double> v);

  Arm arm_;
  dynamics::RobotModel weightless_;  ///< without gravity and linear torques
  dynamics::Workspace<double> ws_, weightless_ws_;
  std::optional<FrictionFollower> follower_;
  double dt_, share_;
  int samples_ = 0;
  std::vector<double> r_, q_, v_, p_, tau_, tau_f_, seen_;  ///< of the last sample
  std::vector<double> seen_before_;                         ///< of the one before
  std::vector<double> seen_v_;
  std::vector<double> v_now_, p_now_, middle_, mean_v_, mean_tau_, gravity_, gradient_, zero_, M_;
};

}  // namespace fricid::estimate
