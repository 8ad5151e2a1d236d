// Ripples have a search of their own: no descent finds the order of a wave.
#pragma once

#include <span>
#include <vector>

#include "fricid/estimate/friction/friction_fit.hpp"

namespace fricid::estimate {

/// Where theta has the terms of a ripple: wave number, amplitude, phase one behind the other.
std::vector<std::size_t> ripple_terms(const friction::RobotFriction& friction);
inline constexpr std::size_t kRippleSize = 3;
constexpr std::size_t ripple_amplitude(std::size_t term) { return term + 1; }

/// The torque of a ripple is periodic in its order n: a descent finds no n that is more than a
/// period over the travel away. So each term is looked for on a grid, in what the law without it
/// leaves.
/// @param friction  of one joint
/// @param terms     see `ripple_terms`
/// @param slow      the first one of the joint too may be of an order below those of gears
void seed_ripples(const JointFrictionData& data, const friction::RobotFriction& friction,
                  std::span<const std::size_t> terms, bool slow, std::span<double> theta);

}  // namespace fricid::estimate
