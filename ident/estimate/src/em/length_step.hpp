// M-step on the lengths of latent states.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "em/score_step.hpp"
#include "fricid/estimate/coordinates.hpp"

namespace fricid::estimate {

/// Indices of the coordinates that are logarithms of a length of latent states (Role::kLength).
std::vector<Eigen::Index> length_coordinates(const ArmPoint& point);

/// Moves the lengths to where the likelihood is greatest: those of all joints, one of each at a
/// time, to c - d, c or c + d, or each to the vertex of the parabola through the likelihoods of
/// its own joint's positions there (at most c -+ 2 d): the length of a joint hardly acts on the
/// others. The likelihood never falls.
/// @param d  (lengths) step of each coordinate, carried from step to step: halved where c stays,
///           else the way that c went, .05 to kMostLengthStep
void climb_by_lengths(const Likelihood& likelihood, Eigen::VectorXd& d, ArmPoint& point);

/// First step of a length's logarithm, a factor of two.
inline constexpr double kMostLengthStep = 0.7;

}  // namespace fricid::estimate
