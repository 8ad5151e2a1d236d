#include "fricid/signals/block_means.hpp"

#include <cmath>

namespace fricid::signals {

Eigen::VectorXd block_means(const Eigen::VectorXd& x, int blocks) {
  const Eigen::Index length = x.size() / blocks;
  Eigen::VectorXd means(blocks);
  for (int b = 0; b < blocks; ++b) {
    double sum = 0;
    int count = 0;
    for (Eigen::Index k = b * length; k < (b + 1) * length; ++k)
      if (std::isfinite(x[k])) {
        sum += x[k];
        ++count;
      }
    means[b] = sum / count;
  }
  return means;
}

}  // namespace fricid::signals
