#include "fricid/optimise/damped_step.hpp"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "fricid/base/progress.hpp"

namespace fricid::optimise {
namespace {

// Shares of the gain that the model expects: of a step below the first the model is trusted less,
// above the second more.
constexpr double kPoor = 0.25, kGood = 0.75;
constexpr double kRaiseOfPoor = 3;  // of lambda

/// Excludes coordinate i from the step.
void hold(Eigen::Index i, Eigen::MatrixXd& H, Eigen::VectorXd& g) {
  H.row(i).setZero();
  H.col(i).setZero();
  H(i, i) = 1;
  g[i] = 0;
}

/// Whether the box keeps coordinate i from where it wants to go, or nothing depends on it.
bool is_held(const Quadratic& here, const Box& box, const Eigen::VectorXd& c, Eigen::Index i) {
  return (c[i] <= box.lower[i] && here.g[i] > 0) || (c[i] >= box.upper[i] && here.g[i] < 0) ||
         here.H(i, i) <= 0;
}

/// Shortens a step to the longest. @return the share of it that may be gone
double shorten(const DampingOptions& options, Eigen::VectorXd& step) {
  if (!options.keep_direction) {
    step = step.cwiseMax(-options.longest).cwiseMin(options.longest);
    return 1;
  }
  const double longest = step.cwiseAbs().maxCoeff();
  return longest > options.longest ? options.longest / longest : 1;
}

Eigen::VectorXd step_from(const Quadratic& here, const Box& box, const DampingOptions& options,
                          double lambda, const Eigen::VectorXd& c) {
  const Eigen::Index n = c.size();
  std::vector<bool> held(static_cast<std::size_t>(n), false);
  for (Eigen::Index i = 0; options.hold_at_bounds && i < n; ++i)
    held[static_cast<std::size_t>(i)] = is_held(here, box, c, i);
  Eigen::VectorXd to_bound = Eigen::VectorXd::Zero(n);  // steps of what is held
  while (true) {
    Eigen::MatrixXd H = here.H;
    Eigen::VectorXd g = here.g + here.H * to_bound;
    for (Eigen::Index i = 0; i < n; ++i)
      if (held[static_cast<std::size_t>(i)])
        hold(i, H, g);
      else
        H(i, i) = H(i, i) * (1 + lambda) + options.ridge;
    Eigen::VectorXd free = -solve_arrow(H, g, here.blocks);
    const double share = shorten(options, free);
    const Eigen::VectorXd step = to_bound + share * free;
    bool leaves = false;
    for (Eigen::Index i = 0; options.hold_at_bounds && i < n; ++i) {
      const auto at = static_cast<std::size_t>(i);
      const double to = c[i] + step[i];
      if (held[at] || (to >= box.lower[i] && to <= box.upper[i])) continue;
      held[at] = leaves = true;
      to_bound[i] = std::clamp(to, box.lower[i], box.upper[i]) - c[i];
    }
    if (!leaves) return box.clamp(c + step);
  }
}

}  // namespace

Step damped_step(const Quadratic& here, const Box& box, const DampingOptions& options,
                 const Objective& objective, double& lambda, Eigen::VectorXd& c, double& value) {
  for (int attempt = 1; attempt <= options.attempts; ++attempt) {
    Eigen::VectorXd trial = step_from(here, box, options, lambda, c);
    const double found = objective(trial);
    if (found < here.value) {
      const Eigen::VectorXd s = trial - c;
      const double expected = here.g.dot(s) + 0.5 * s.dot(here.H * s);
      const double share = (found - here.value) / expected;  // of the gain that came
      if (share < kPoor)
        lambda = std::min(lambda * kRaiseOfPoor, options.most);
      else if (share > kGood && attempt == 1)
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
    const double before = lambda;
    const Step step = damped_step(here, box, options.damping, objective, lambda, at.c, at.value);
    at.values += step.values;
    if (!step.lowered || (here.value - at.value) / here.value < options.smallest_gain) {
      if (options.refresh && options.refresh()) {
        if (!step.lowered) lambda = before;
        continue;
      }
      at.converged = true;
      return at;
    }
  }
  return at;
}

}  // namespace fricid::optimise
