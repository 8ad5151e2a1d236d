// Result of a search.
#pragma once

#include <Eigen/Core>

namespace fricid::optimise {

struct Minimum {
  Eigen::VectorXd c;
  double value = 0;        ///< of the objective at c
  bool converged = false;  ///< its stopping rule was met; false: evaluations ran out
  int values = 0;          ///< number of evaluations of the objective
};

}  // namespace fricid::optimise
