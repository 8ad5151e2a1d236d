#include "fricid/optimise/damped_step.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "fricid/base/progress.hpp"

namespace fricid::optimise {
namespace {

/// Excludes coordinate i from the step.
void hold(Eigen::Index i, Eigen::MatrixXd& H, Eigen::VectorXd& g) {
  H.row(i).setZero();
  H.col(i).setZero();
  H(i, i) = 1;
  g[i] = 0;
}

Eigen::VectorXd step_from(const Quadratic& here, const Box& box, const DampingOptions& options,
                          double lambda, const Eigen::VectorXd& c) {
  Eigen::MatrixXd H = here.H;
  Eigen::VectorXd g = here.g;
  for (Eigen::Index i = 0; i < c.size(); ++i) {
    const bool presses = (c[i] <= box.lower[i] && g[i] > 0) || (c[i] >= box.upper[i] && g[i] < 0);
    if (options.hold_at_bounds && (presses || H(i, i) <= 0))
      hold(i, H, g);
    else
      H(i, i) = H(i, i) * (1 + lambda) + options.ridge;
  }
  const Eigen::VectorXd step = -solve_arrow(H, g, here.blocks);
  if (!options.keep_direction)
    return box.clamp(c + step.cwiseMax(-options.longest).cwiseMin(options.longest));
  const double longest = step.cwiseAbs().maxCoeff();
  const double share = longest > options.longest ? options.longest / longest : 1;
  return box.clamp(c + share * step);
}

}  // namespace

Step damped_step(const Quadratic& here, const Box& box, const DampingOptions& options,
                 const Objective& objective, double& lambda, Eigen::VectorXd& c, double& value) {
  for (int attempt = 1; attempt <= options.attempts; ++attempt) {
    Eigen::VectorXd trial = step_from(here, box, options, lambda, c);
    const double found = objective(trial);
    if (found < here.value) {
      lambda = std::max(lambda / options.lessen, options.least);
      c = std::move(trial);
      value = found;
      return {true, attempt};
    }
    lambda = std::min(lambda * options.raise, options.most);
    if (lambda >= options.most) return {false, attempt};
  }
  return {false, options.attempts};
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
    if (!step.lowered || (here.value - at.value) / here.value < options.smallest_gain) {
      at.converged = true;
      return at;
    }
  }
  return at;
}

}  // namespace fricid::optimise
