// M-step on the likelihood itself.
#pragma once

#include <Eigen/Core>
#include <span>

#include "fricid/estimate/coordinates.hpp"
#include "fricid/estimate/em/innovations.hpp"
#include "fricid/estimate/windows/multi_step.hpp"

namespace fricid::estimate {

/// The likelihood of the training parts under the extended Kalman filter, for one noise and one
/// start of each recording.
struct Likelihood {
  std::span<const signals::Recording> recordings;
  const Split& split;
  StepOptions step;
  const LatentNoise& noise;
  std::span<const smc::Gaussian> starts;
  int jobs;

  InnovationScore score(const Arm& arm) const;
  /// -inf when the filter fails.
  double value(const Arm& arm) const;
};

/// Moves the point by one step of Fisher scoring, damped until the likelihood rises; leaves it
/// where none does.
/// @param damping  carried from step to step
void climb_by_score(const Likelihood& likelihood, double& damping, ArmPoint& point);

}  // namespace fricid::estimate
