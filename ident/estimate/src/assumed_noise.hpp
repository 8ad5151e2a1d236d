// Noise of a model whose method estimates none.
#pragma once

#include <Eigen/Core>
#include <span>

#include "fricid/estimate/prepared.hpp"
#include "fricid/system/arm.hpp"
#include "fricid/system/noise.hpp"

namespace fricid::estimate {

/// LatentNoise::friction (n) of a fit: by what it left of the training torque friction may err.
/// @param residual_rms  (n) of the motor torque [N m]
Eigen::VectorXd friction_left(std::span<const double> residual_rms);

/// Noise of a filter whose latent states follow the motion (a thousandth of their size per sample)
/// and whose velocity is moved by the white noise of the measured torque and by what the model
/// leaves of it. The latter lasts: it counts as often as the filter has samples in its memory.
/// Noises of positions and velocities are larger than that, since 200 particles cannot follow
/// six joints at the noises themselves (docs/use_it.md).
/// @param residual_rms  (n) of the motor torque [N m]
LatentNoise assumed_noise(const Arm& arm, const Prepared& prepared,
                          std::span<const double> residual_rms);

}  // namespace fricid::estimate
