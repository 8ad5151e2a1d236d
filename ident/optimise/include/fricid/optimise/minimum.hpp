// Result of a search.
#pragma once

#include <Eigen/Core>

namespace fricid::optimise {

struct Minimum {
  Eigen::VectorXd c;
  double value = 0;        ///< objective at c
  bool converged = false;  ///< the stopping rule was met; false: out of evaluations
  int values = 0;          ///< number of evaluations of the objective
};

}  // namespace fricid::optimise
