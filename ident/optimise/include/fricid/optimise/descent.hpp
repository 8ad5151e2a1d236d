// Stochastic gradient descent with the result chosen on held-out data.
#pragma once

#include <Eigen/Core>
#include <concepts>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "fricid/base/progress.hpp"

namespace fricid::optimise {

struct DescentOptions {
  int iterations = 1000;
  double rate = 1;  ///< first step length, see `step_length`
  int checks = 10;  ///< evaluations of the held-out error, evenly spread over the iterations
  /// If the held-out error exceeds `lost` times the best one, the descent returns to the best point
  /// and multiplies its step length by `shorter`; infinite: never.
  double lost = std::numeric_limits<double>::infinity();
  double shorter = 0.3;
};

/// Step length over the course of a descent, relative to the first: 1, 0.3 after 60 % and 0.1 after
/// 85 % of the iterations.
double step_length(int iteration, int iterations);

/// History of a descent.
struct DescentHistory {
  std::vector<double> loss;      ///< of each iteration's batch
  std::vector<int> checked;      ///< iterations after which held-out error was evaluated; first 0
  std::vector<double> held_out;  ///< one per entry of `checked`
  int best = 0;                  ///< index of the chosen entry
  int skipped = 0;               ///< iterations without a finite gradient
  int returns = 0;               ///< returns to the best point, see DescentOptions::lost

  double best_held_out() const { return held_out[static_cast<std::size_t>(best)]; }
  int best_iteration() const { return checked[static_cast<std::size_t>(best)]; }
};

/// The point of a descent: a value with coordinates c and all quantities derived from them.
template <class P>
concept DescentPoint = std::copyable<P> &&
    requires(P point, const P given, const Eigen::VectorXd& c) {
  { given.c() } -> std::convertible_to<Eigen::VectorXd>;
  point.move_to(c);
};

/// Objective and update rule:
///
///     begin(point)         before the first step from a point: reset the optimiser's state
///     prepare(k, point)    before iteration k: update quantities that are not differentiated
///     loss(point, g)       loss of the next random batch and its gradient with respect to c
///     step(point, g, r)    c after a step of length r and true; c and false if g is not finite
///     held_out(point)      error on held-out data
///     describe(l, h)       text of loss l and held-out error h for the progress line
template <class D, class P>
concept DescentProblem = requires(D problem, const P point, int iteration, Eigen::VectorXd& g,
                                  double x) {
  problem.begin(point);
  problem.prepare(iteration, point);
  { problem.loss(point, g) } -> std::same_as<double>;
  { problem.step(point, g, x) } -> std::same_as<std::pair<Eigen::VectorXd, bool>>;
  { problem.held_out(point) } -> std::same_as<double>;
  { problem.describe(x, x) } -> std::convertible_to<std::string>;
};

/// Descends from `point` and leaves in it the checked point of smallest held-out error, the start
/// included. The result does not depend on the number of threads.
/// @throws Stopped on Ctrl-C
template <DescentPoint Point, DescentProblem<Point> Problem>
DescentHistory descend(Problem& problem, Point& point, const DescentOptions& options,
                       const std::string& title) {
  DescentHistory history;
  Point best = point;
  const auto look = [&](int iteration) {
    history.checked.push_back(iteration);
    history.held_out.push_back(problem.held_out(point));
    if (history.held_out.back() < history.best_held_out()) {
      history.best = static_cast<int>(history.held_out.size()) - 1;
      best = point;
    }
  };
  look(0);
  point.move_to(point.c());  // projects onto the range of the coordinates
  problem.begin(point);
  double share = 1;
  Eigen::VectorXd gradient;
  Progress progress(title, options.iterations);
  for (int iteration = 0; iteration < options.iterations; ++iteration) {
    throw_if_stopped();
    problem.prepare(iteration, point);
    history.loss.push_back(problem.loss(point, gradient));
    const auto [c, moved] = problem.step(
        point, gradient, share * options.rate * step_length(iteration, options.iterations));
    if (!moved) ++history.skipped;
    point.move_to(c);
    const int done = iteration + 1;
    if (done * options.checks / options.iterations >
        iteration * options.checks / options.iterations) {
      look(done);
      const bool lost = history.held_out.back() > options.lost * history.best_held_out();
      if (lost && done < options.iterations) {
        point = best;
        point.move_to(point.c());
        share *= options.shorter;
        ++history.returns;
        problem.begin(point);
      }
    }
    progress.advance(1, problem.describe(history.loss.back(), history.held_out.back()));
  }
  point = std::move(best);
  return history;
}

}  // namespace fricid::optimise
