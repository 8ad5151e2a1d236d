// The simplex search of Nelder and Mead.
#pragma once

#include "fricid/optimise/box.hpp"
#include "fricid/optimise/damped_step.hpp"
#include "fricid/optimise/minimum.hpp"

namespace fricid::optimise {

struct SimplexOptions {
  double first_step = 0.4;  ///< of the simplex, in every coordinate
  double tolerance = 1e-4;  ///< absolute on the coordinates, relative on the objective
  int evaluations = 200;    ///< at most
};

/// Nelder & Mead (Computer J. 7(4), 1965) inside a box (NLopt) from c. The objective must be finite
/// everywhere.
/// @throws Stopped on Ctrl-C
Minimum nelder_mead(const Objective& objective, const Box& box, Eigen::VectorXd c,
                    const SimplexOptions& options);

}  // namespace fricid::optimise
