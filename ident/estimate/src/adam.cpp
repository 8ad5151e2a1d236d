#include "fricid/estimate/adam.hpp"

#include <algorithm>
#include <cmath>

#include "training.hpp"

namespace fricid::estimate {
namespace {

constexpr double kB1 = 0.9, kB2 = 0.999, kEpsilon = 1e-10;

}  // namespace

bool Adam::step(const Eigen::VectorXd& gradient, double rate, const Eigen::VectorXd& rates,
                const Eigen::VectorXd& lower, const Eigen::VectorXd& upper, Eigen::VectorXd& x) {
  const double length = gradient.norm();
  if (!std::isfinite(length)) return false;
  ++k_;
  const double shrink = shorten_gradient(length, k_, mean_length_);
  m_ = kB1 * m_ + (1 - kB1) * shrink * gradient;
  s_ = kB2 * s_ + (1 - kB2) * (shrink * gradient).cwiseAbs2();
  const double m_share = 1 - std::pow(kB1, k_), s_share = 1 - std::pow(kB2, k_);
  for (Eigen::Index i = 0; i < x.size(); ++i) {
    const double move = m_[i] / m_share / (std::sqrt(s_[i] / s_share) + kEpsilon);
    x[i] = std::clamp(x[i] - rate * rates[i] * move, lower[i], upper[i]);
  }
  return true;
}

std::vector<double> Adam::state() const {
  std::vector<double> out(m_.begin(), m_.end());
  out.insert(out.end(), s_.begin(), s_.end());
  out.insert(out.end(), {mean_length_, static_cast<double>(k_)});
  return out;
}

void Adam::restore(std::span<const double> state) {
  const auto size = static_cast<std::size_t>(m_.size());
  std::copy_n(state.begin(), size, m_.begin());
  std::copy_n(state.begin() + m_.size(), size, s_.begin());
  mean_length_ = state[2 * size];
  k_ = static_cast<int>(state[2 * size + 1]);
}

}  // namespace fricid::estimate
