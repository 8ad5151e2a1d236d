// Refinement of a fit to the torque on open-loop windows.
#pragma once

#include <span>
#include <string_view>

#include "fricid/estimate/windows/multi_step.hpp"
#include "fricid/optimise/damped_step.hpp"

namespace fricid::estimate {

/// What the torque says of an arm: its objective, quadratic in coordinates about c.
struct TorquePull {
  Eigen::VectorXd c;
  optimise::Quadratic about;  ///< half of the squares, in units of their size at c
};

/// Minimises over the arm's coordinates, by damped Gauss-Newton steps,
///
///     m n L(c)/L(c_0) + T(c)
///
/// with L the loss of `kWindows` windows spread over the training part (`WindowRollout`), T what
/// the torque says, n joints, and m how many windows the training part holds side by side: L counts
/// as two independent numbers per joint and window of it, both terms as halves of squares of data
/// in units of their size. Of the curvature of L every step samples one vector per window and
/// forgets half of what earlier steps sampled. Windows whose gradients explode are chaos, to which
/// no step is downhill: where they are many, steps of the simulation are halved; those that are
/// left over are left out. Returns the point on the way with the smallest held-out error, the start
/// included, of those whose inertias are within a factor of 1.5 of what the torque says.
/// Deterministic for a seed, whatever `jobs`.
/// @throws UserError when a recording is shorter than two windows; Stopped on Ctrl-C
MultiStepReport refine_on_windows(const Arm& start, const TorquePull& torque,
                                  std::span<const signals::Recording> recordings,
                                  const MultiStepOptions& options, std::string_view label,
                                  int jobs);

}  // namespace fricid::estimate
