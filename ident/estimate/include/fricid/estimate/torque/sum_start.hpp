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

/// `arm` with the friction `joints`. The laws of a joint that have Coulomb friction begin with
/// equal shares of it and hardly a Stribeck effect, several springs in equal shares on lengths from
/// 0.15 to 8 mrad, one on 1 mrad; one law, the first without memory if there is one, holds the
/// linear viscous friction, half of it where a power law has the other half. Linear viscous
/// friction of other laws, modifiers and load parts (their Coulomb friction too) are near zero.
/// Speeds and lengths of a sliding joint are a tenth of these numbers, in m/s and m.
Arm start_sum(const Arm& arm, std::vector<friction::JointSpec> joints, const SumStart& start);

/// Parameters that a fit holds, or keeps inside narrower bounds: speeds that smooth a corner and
/// reference temperatures (constants of the host, not of the joint), the corners of load parts (a
/// fourth to four times of 0.03 rad/s and 0.3 N m), Stribeck velocities
/// (.005 to .5 rad/s, to 1 of a law beside a bank; sliding a tenth in m/s), the attraction of a
/// bank (5 to 300 Fc per second: the torque does not determine it beyond), and what a sum has twice
/// (linear viscous friction outside the law that holds it and Coulomb friction of load parts, see
/// `start_sum`).
std::vector<Limit> sum_limits(const Arm& arm);
/// Indices in theta of Stribeck velocities on the least that `sum_limits` leaves them.
std::vector<std::size_t> slowest_stribeck_velocities(const Arm& arm);

/// Indices in theta of the speeds and loads below which the load parts fade (v0, l0).
std::vector<std::size_t> load_corners(const friction::RobotFriction& model);

/// The networks of a sum, held as they are: windows of a quarter of a second would fit their many
/// weights to noise.
std::vector<Limit> held_networks(const friction::Friction& friction);

}  // namespace fricid::estimate
