// Start values of the fit of the sum of laws, and the parameters that it holds.
#pragma once

#include <vector>

#include "fricid/estimate/options/limit.hpp"
#include "fricid/friction/sum.hpp"
#include "fricid/system/arm.hpp"

namespace fricid::estimate {

/// What is known of the joints before the sum is fitted.
struct SumStart {
  std::vector<friction::FrictionGuess> joints;  ///< (n) linear friction
  std::vector<double> load;                     ///< (n) size of the torque [N m]
  double temperature = 0;                       ///< mean of the training data [K]
};

/// `arm` with the friction `lvm_sum(parts[j])` in joint j: the memory holds the Coulomb friction
/// with hardly a Stribeck effect, a bank in equal shares on lengths from 0.15 to 8 mrad; half of
/// the viscous torque is linear; modifiers and the load part are near zero.
Arm start_sum(const Arm& arm, const std::vector<friction::LvmParts>& parts, const SumStart& start);

/// Parameters that a fit holds, or keeps inside narrower bounds: speeds and loads that smooth a
/// corner and reference temperatures (constants of the host, not of the joint), Stribeck velocities
/// (.02 to .5 rad/s), the attraction of a bank (5 to 300 Fc per second: the torque does not
/// determine it beyond), and what a sum has twice (Coulomb friction beside the memory, linear
/// viscous friction outside coulomb_viscous; the square of the load beside its growth).
std::vector<Limit> sum_limits(const friction::Friction& friction);

}  // namespace fricid::estimate
