// Levenberg-Marquardt on coordinates of order one, inside a box.
#pragma once

#include <Eigen/Core>
#include <functional>

#include "fricid/optimise/arrow.hpp"
#include "fricid/optimise/box.hpp"
#include "fricid/optimise/minimum.hpp"

namespace fricid::optimise {

/// Gauss-Newton model about a point c of a sum of squares with the residuals' Jacobian J:
///
///     f(c + s) = value + g's + s'H s / 2,   H ~ J'J.
struct Quadratic {
  double value = 0;
  Eigen::VectorXd g;
  Eigen::MatrixXd H;
  std::vector<Block> blocks{};  ///< of H, see `solve_arrow`; none: it is full
};

struct DampingOptions {
  double longest = 0.3;  ///< largest step in any coordinate
  /// Of a step that is too long: true: shortened as a whole; false: cut coordinate by coordinate.
  bool keep_direction = false;
  double ridge = 0;     ///< mu: penalty on the length of the step
  int attempts = 5;     ///< at most
  double first = 1e-3;  ///< lambda of a new search
  double lessen = 5;    ///< lambda is divided by it after a step that gains what was expected ...
  double raise = 10;    ///< ... and multiplied by it after one that gains nothing
  double least = 1e-9, most = 1e6;  ///< bounds of lambda; at `most` no further step is tried
  /// True: coordinates that the step would take out of the box stay on their bound, and the others
  /// are solved for again; those without effect are held.
  /// False: they take part and the step is clamped.
  bool hold_at_bounds = false;
};

/// Result of a step.
struct Step {
  bool lowered = false;  ///< whether the objective fell
  int values = 0;        ///< number of evaluations of the objective
};

using Objective = std::function<double(const Eigen::VectorXd& c)>;

/// One step
///
///     s = -(H + lambda diag H + mu I)^-1 g
///
/// limited to `longest` per coordinate (see keep_direction) and kept in the box (see
/// hold_at_bounds); lambda is raised until the objective falls below here.value, and adapted to the
/// share of -(g's + s'H s / 2), the gain that the model expects, that came.
/// @param here    model about c
/// @param lambda  carried from step to step
/// @param c       moved, unless no step lowered the objective
/// @param value   objective at the new c; set when c moves
/// @see Levenberg 1944; Marquardt, SIAM J. 11(2), 1963
Step damped_step(const Quadratic& here, const Box& box, const DampingOptions& options,
                 const Objective& objective, double& lambda, Eigen::VectorXd& c, double& value);

struct LeastSquaresOptions {
  DampingOptions damping;
  int iterations = 40;
  double smallest_gain = 0;  ///< stop after a step that lowers the objective by a smaller share
  /// Asked before it stops: drops derivatives of earlier points. @return whether there were any
  std::function<bool()> refresh{};
};

/// Model of the objective about c. @param value  objective at c if known, else NaN
using Linearise = std::function<Quadratic(const Eigen::VectorXd& c, double value)>;

/// Damped steps until one gains too little. A model that is not finite ends the search without
/// convergence.
/// @param start  c, and the objective there or NaN
/// @throws Stopped on Ctrl-C
Minimum damped_least_squares(const Linearise& linearise, const Objective& objective, const Box& box,
                             Minimum start, const LeastSquaresOptions& options);

}  // namespace fricid::optimise
