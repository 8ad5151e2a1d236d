#include "fricid/estimate/gauss_newton.hpp"

#include <algorithm>
#include <cmath>

#include "fricid/base/parallel.hpp"
#include "training.hpp"

namespace fricid::estimate {
namespace {

constexpr double kMemory = 0.8, kMomentum = 0.9;
constexpr float kDamping = 1e-2F, kRidge = 1e-4F;  // lambda, mu
constexpr double kLongest = 0.3;
constexpr Eigen::Index kPanel = 256;  // rows of F that a thread adds to at a time

}  // namespace

GaussNewton::GaussNewton(Eigen::Index size)
    : F_(Eigen::MatrixXf::Zero(size, size)), factor_(size), m_(Eigen::VectorXd::Zero(size)) {}

void GaussNewton::refresh(const Eigen::Ref<const Eigen::MatrixXf>& samples, int jobs) {
  const double keep = mass_ > 0 ? kMemory : 0;
  mass_ = keep * mass_ + (1 - keep);
  const auto weight = static_cast<float>((1 - keep) / static_cast<double>(samples.cols()));
  const Eigen::Index size = F_.rows();
  parallel_for(static_cast<int>((size + kPanel - 1) / kPanel), jobs, [&](int p) {
    const Eigen::Index first = p * kPanel, rows = std::min(kPanel, size - first);
    auto part = F_.block(first, 0, rows, first + rows);
    part *= static_cast<float>(keep);
    part.noalias() +=
        weight * samples.middleRows(first, rows) * samples.topRows(first + rows).transpose();
  });
  Eigen::MatrixXf damped = F_ / static_cast<float>(mass_);
  damped.diagonal() *= 1 + kDamping;
  damped.diagonal().array() += kRidge;
  factor_.compute(damped);
}

bool GaussNewton::step(const Eigen::VectorXd& gradient, double rate, const Eigen::VectorXd& lower,
                       const Eigen::VectorXd& upper, Eigen::VectorXd& x) {
  const double length = gradient.norm();
  if (!std::isfinite(length)) return false;
  ++k_;
  const double shrink = shorten_gradient(length, k_, mean_length_);
  m_ = kMomentum * m_ + (1 - kMomentum) * shrink * gradient;
  const Eigen::VectorXf m = (m_ / (1 - std::pow(kMomentum, k_))).cast<float>();
  const Eigen::VectorXd move = factor_.solve(m).cast<double>();
  const double longest = rate * move.cwiseAbs().maxCoeff();
  const double share = longest > kLongest ? rate * kLongest / longest : rate;
  x = (x - share * move).cwiseMax(lower).cwiseMin(upper);
  return true;
}

}  // namespace fricid::estimate
