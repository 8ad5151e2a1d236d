// M-step on the likelihood itself.
#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

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
  /// Of each arm, joint by joint (n): of the positions of joint j given those of the joints before
  /// it. -inf when the filter fails.
  std::vector<Eigen::VectorXd> by_joint(std::span<const Arm> arms) const;
  double value(const Arm& arm) const { return by_joint({&arm, 1})[0].sum(); }
};

/// Moves the point by one step of Fisher scoring, damped until the likelihood rises; leaves it
/// where none does.
/// @param damping  carried from step to step
void climb_by_score(const Likelihood& likelihood, double& damping, ArmPoint& point);

}  // namespace fricid::estimate
