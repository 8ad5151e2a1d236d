// M-step on the lengths of latent states.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "em/score_step.hpp"
#include "fricid/estimate/coordinates.hpp"

namespace fricid::estimate {

/// Indices of the coordinates that are logarithms of a length of latent states (Role::kLength).
std::vector<Eigen::Index> length_coordinates(const ArmPoint& point);

/// Moves the lengths, one after the other, to where the likelihood is greatest along each: at
/// c - d, c, c + d or the vertex of the parabola through the three (at most c -+ 2 d). The
/// likelihood never falls.
/// @param d  (lengths) step of each coordinate, carried from step to step: halved where c stays,
///           else the way that c went, .05 to kMostLengthStep
void climb_by_lengths(const Likelihood& likelihood, Eigen::VectorXd& d, ArmPoint& point);

/// First step of a length's logarithm, a factor of two.
inline constexpr double kMostLengthStep = 0.7;

}  // namespace fricid::estimate
