#include "fricid/smc/normal_distribution.hpp"

#include <numbers>

namespace fricid::smc {

double normal_quantile(double p) {
  if (p > 0.5) return -normal_quantile(1 - p);
  // Abramowitz & Stegun 26.2.23, error below 4.5e-4, then two steps of third order
  const double r = std::sqrt(-2 * std::log(p));
  double x = (2.515517 + r * (0.802853 + r * 0.010328)) /
                 (1 + r * (1.432788 + r * (0.189269 + r * 0.001308))) -
             r;
  for (int i = 0; i < 2; ++i) {
    const double density = std::exp(-0.5 * x * x) / std::sqrt(2 * std::numbers::pi);
    const double step = (normal_cdf(x) - p) / density;
    x -= step / (1 + 0.5 * x * step);
  }
  return x;
}

}  // namespace fricid::smc
