// Levenberg-Marquardt on coordinates of order one, inside a box.
#pragma once

#include <Eigen/Core>
#include <functional>

#include "fricid/optimise/box.hpp"
#include "fricid/optimise/minimum.hpp"

namespace fricid::optimise {

/// An objective about a point c, as the squares of residuals with Jacobian J make it:
///
///     f(c + s) = value + g's + s'H s / 2,   H ~ J'J.
struct Quadratic {
  double value = 0;
  Eigen::VectorXd g;
  Eigen::MatrixXd H;
};

struct DampingOptions {
  double longest = 0.3;  ///< of a step in any coordinate
  double ridge = 0;      ///< mu: a pull to where the step starts
  int attempts = 5;      ///< at most
  double first = 1e-3;   ///< lambda of a new search
  double lessen = 5;     ///< lambda is divided by it after a step that lowers the objective ...
  double raise = 10;     ///< ... and multiplied by it after one that does not
  double least = 1e-9, most = 1e6;  ///< of lambda; no step is tried after it has risen to `most`
  /// True: coordinates that press against a bound, or that do not affect the objective, are held.
  /// False: they take part and the step is clamped.
  bool hold_at_bounds = false;
};

/// Result of a step.
struct Step {
  bool lowered = false;  ///< the objective
  int values = 0;        ///< number of evaluations of the objective
};

using Objective = std::function<double(const Eigen::VectorXd& c)>;

/// One step
///
///     s = -(H + lambda diag H + mu I)^-1 g
///
/// no coordinate further than `longest`, clamped to the box; lambda rises until the objective falls
/// below here.value.
/// @param here    about c
/// @param lambda  carried from step to step
/// @param c       moved, unless no step lowered the objective
/// @param value   of the objective at the new c, set with it
/// @see Levenberg 1944; Marquardt, SIAM J. 11(2), 1963
Step damped_step(const Quadratic& here, const Box& box, const DampingOptions& options,
                 const Objective& objective, double& lambda, Eigen::VectorXd& c, double& value);

struct LeastSquaresOptions {
  DampingOptions damping;
  int iterations = 40;
  double smallest_gain = 0;  ///< a step that lowers the objective by a smaller share is the last
};

/// The objective about c. @param value  of it at c where the search knows it, else NaN
using Linearise = std::function<Quadratic(const Eigen::VectorXd& c, double value)>;

/// Damped steps until one gains too little. Where the objective is not finite about c, the search
/// ends without having converged.
/// @param start  `value` NaN where it is not known
/// @throws Stopped on Ctrl-C
Minimum damped_least_squares(const Linearise& linearise, const Objective& objective, const Box& box,
                             Minimum start, const LeastSquaresOptions& options);

}  // namespace fricid::optimise
