#include "fricid/evaluate/reversals.hpp"

#include <cmath>

namespace fricid::evaluate {

std::vector<bool> after_reversals(ConstRowMatrix v, Eigen::Index j, double dt) {
  constexpr double kAfter = 0.2;  // [s]
  const Eigen::Index window = std::lround(kAfter / dt);
  std::vector<bool> after(static_cast<std::size_t>(v.rows()));
  double direction = 0;
  Eigen::Index turned = -window;
  for (Eigen::Index k = 0; k < v.rows(); ++k) {
    if (v(k, j) * direction < 0) turned = k;
    if (v(k, j) != 0) direction = v(k, j);
    after[static_cast<std::size_t>(k)] = k - turned < window;
  }
  return after;
}

}  // namespace fricid::evaluate
