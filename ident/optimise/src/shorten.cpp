#include "shorten.hpp"

namespace fricid::optimise {

double shorten_gradient(double length, int step, double& mean_length) {
  constexpr double kClip = 3, kMemory = 0.95;
  const double share = step > 1 && length > kClip * mean_length ? kClip * mean_length / length : 1;
  mean_length = step == 1 ? length : kMemory * mean_length + (1 - kMemory) * share * length;
  return share;
}

}  // namespace fricid::optimise
