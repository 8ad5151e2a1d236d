#include "fricid/optimise/damped_step.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "fricid/base/progress.hpp"
#include "fricid/optimise/box_quadratic.hpp"

namespace fricid::optimise {
namespace {

// Of the change of the objective that the model promises: a step that brings more than the one
// lessens the damping, one that brings less than the other raises it.
constexpr double kGood = 0.75, kPoor = 0.25;
constexpr double kShorter = 0.5;  // times the last attempt's reach

/// @param longest  in any coordinate
Eigen::VectorXd step_from(const Quadratic& here, const Box& box, const DampingOptions& options,
                          double lambda, double longest, const Eigen::VectorXd& c) {
  Eigen::MatrixXd H = here.H;
  Box reach{(box.lower - c).cwiseMax(-longest), (box.upper - c).cwiseMin(longest)};
  for (Eigen::Index i = 0; i < c.size(); ++i) {
    const bool acts = H(i, i) > 0;
    if (!acts) reach.lower[i] = reach.upper[i] = 0;
    H(i, i) = acts ? H(i, i) * (1 + lambda) + options.ridge : 1;
  }
  return box.clamp(c + least_in_box(H, here.g, here.blocks, reach));
}

}  // namespace

Step damped_step(const Quadratic& here, const Box& box, const DampingOptions& options,
                 const Objective& objective, double& lambda, Eigen::VectorXd& c, double& value) {
  const auto lessen = [&] { lambda = std::max(lambda / options.lessen, options.least); };
  const auto raise = [&] { lambda = std::min(lambda * options.raise, options.most); };
  double longest = options.longest;
  for (int attempt = 1; attempt <= options.attempts; ++attempt, longest *= kShorter) {
    Eigen::VectorXd trial = step_from(here, box, options, lambda, longest, c);
    const double found = objective(trial);
    if (found < here.value) {
      const Eigen::VectorXd s = trial - c;
      const double promised = -(here.g.dot(s) + 0.5 * s.dot(here.H * s));
      const double kept = (here.value - found) / promised;
      if (kept > kGood) lessen();
      if (kept < kPoor) raise();
      c = std::move(trial);
      value = found;
      return {.lowered = true, .poor = kept < kPoor, .values = attempt};
    }
    raise();
    if (lambda >= options.most) return {.values = attempt};
  }
  return {.values = options.attempts};
}

Minimum damped_least_squares(const Linearise& linearise, const Objective& objective, const Box& box,
                             Minimum at, const LeastSquaresOptions& options) {
  double lambda = options.damping.first;
  at.converged = false;
  for (int iteration = 0; iteration < options.iterations; ++iteration) {
    throw_if_stopped();
    const Quadratic here = linearise(at.c, at.value);
    at.value = here.value;
    if (!std::isfinite(here.value) || !here.H.allFinite()) return at;
    const Step step = damped_step(here, box, options.damping, objective, lambda, at.c, at.value);
    at.values += step.values;
    const double gain = (here.value - at.value) / here.value;
    if (!step.lowered || (gain < options.smallest_gain && !step.poor)) {
      at.converged = true;
      return at;
    }
  }
  return at;
}

}  // namespace fricid::optimise
