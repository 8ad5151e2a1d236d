#include "fricid/optimise/descent.hpp"

namespace fricid::optimise {

double step_length(int iteration, int iterations) {
  const double done = static_cast<double>(iteration) / iterations;
  return done < 0.6 ? 1 : done < 0.85 ? 0.3 : 0.1;
}

}  // namespace fricid::optimise
