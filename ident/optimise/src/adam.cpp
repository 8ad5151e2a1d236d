#include "fricid/optimise/adam.hpp"

#include <algorithm>
#include <cmath>

#include "shorten.hpp"

namespace fricid::optimise {
namespace {

constexpr double kB1 = 0.9, kB2 = 0.999, kEpsilon = 1e-10;

}  // namespace

bool Adam::step(const Eigen::VectorXd& gradient, double rate, const Eigen::VectorXd& rates,
                const Box& box, Eigen::VectorXd& x) {
  const double length = gradient.norm();
  if (!std::isfinite(length)) return false;
  ++k_;
  const double shrink = shorten_gradient(length, k_, mean_length_);
  m_ = kB1 * m_ + (1 - kB1) * shrink * gradient;
  s_ = kB2 * s_ + (1 - kB2) * (shrink * gradient).cwiseAbs2();
  const double m_share = 1 - std::pow(kB1, k_), s_share = 1 - std::pow(kB2, k_);
  for (Eigen::Index i = 0; i < x.size(); ++i) {
    const double move = m_[i] / m_share / (std::sqrt(s_[i] / s_share) + kEpsilon);
    x[i] = std::clamp(x[i] - rate * rates[i] * move, box.lower[i], box.upper[i]);
  }
  return true;
}

}  // namespace fricid::optimise
