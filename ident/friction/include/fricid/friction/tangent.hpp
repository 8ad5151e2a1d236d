// Forward sensitivities of friction to its parameters.
#pragma once

#include <span>

#include "fricid/friction/robot_friction.hpp"

namespace fricid::friction {

/// How the states of a friction follow its parameters, carried forward in time with them. With
/// z' = step(theta, z) and inputs held,
///
///     dz'/dtheta = dstep/dz dz/dtheta + dstep/dtheta,
///     dtau/dtheta = dtorque/dz dz/dtheta + dtorque/dtheta.
///
/// Laws of at most one state are differentiated by their pullbacks; one of several states has to
/// say how (gms does):
///
///     int tangent_size() const;
///     void step_tangent(const S* theta, const Input<S>& in, double dt, const S* z, S* T) const;
///                                                       T after a step from z, in place
///     void add_tangent(const S* theta, const S* z_bar, const S* T, S* theta_bar) const;
///                                                       theta_bar += (dz/dtheta)' z_bar
///
/// and, to be known behind backlash too, where the velocity of the law follows the parameters,
///
///     void step_slopes(const S* theta, const Input<S>& in, double dt, const S* z, S* by_z,
///                      S* by_v) const;                  dz_i'/dz_i and dz_i'/dv
class Tangent {
 public:
  /// Whether that is known: not for recurrent networks, a law of the whole robot, and laws of
  /// several states that do not say how.
  static bool is_known(const RobotFriction& model);

  /// At rest, where z does not depend on theta. @pre is_known(model)
  explicit Tangent(const RobotFriction& model);

  void reset();  ///< dz/dtheta = 0

  /// Advances z as RobotFriction::step does, and dz/dtheta with it.
  void step(std::span<const PackD> theta, std::span<const Input<PackD>> in, double dt,
            std::span<PackD> z);

  /// theta_bar += (dz/dtheta)' z_bar: after RobotFriction::torque_pullback, with the z_bar that it
  /// makes, theta_bar holds dtau/dtheta along the motion so far.
  void add(std::span<const PackD> theta, std::span<const PackD> z_bar,
           std::span<PackD> theta_bar) const;

 private:
  const RobotFriction& model_;
  std::vector<PackD> T_;  // dz/dtheta law by law, each in a form of its own
};

}  // namespace fricid::friction
