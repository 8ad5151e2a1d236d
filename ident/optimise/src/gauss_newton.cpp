#include "fricid/optimise/gauss_newton.hpp"

#include <Eigen/Cholesky>

#include <algorithm>
#include <cmath>

#include "fricid/base/parallel.hpp"
#include "shorten.hpp"

namespace fricid::optimise {
namespace {

constexpr double kMemory = 0.8, kMomentum = 0.9;
constexpr float kDamping = 1e-2F, kRidge = 1e-4F;  // lambda, mu
constexpr double kLongest = 0.3;
constexpr float kOutlier = 10;        // times the median length, of a sample
constexpr Eigen::Index kPanel = 256;  // rows that a thread works on at a time

/// body(first row, rows) for the panels of rows begin .. size - 1, the last and longest first:
/// cores are then done at about the same time.
template <class Body>
void for_panels(Eigen::Index begin, Eigen::Index size, int jobs, Body body) {
  const int panels = static_cast<int>((size - begin + kPanel - 1) / kPanel);
  parallel_for(panels, jobs, [&](int p) {
    const Eigen::Index first = begin + (panels - 1 - p) * kPanel;
    body(first, std::min(kPanel, size - first));
  });
}

/// Replaces the lower triangle of A by its Cholesky factor, panel by panel.
/// @return false where A is not positive definite
bool factorise(Eigen::MatrixXf& A, int jobs) {
  const Eigen::Index size = A.rows();
  for (Eigen::Index k = 0; k < size; k += kPanel) {
    const Eigen::Index width = std::min(kPanel, size - k), rest = k + width;
    Eigen::Ref<Eigen::MatrixXf> corner = A.block(k, k, width, width);
    if (Eigen::LLT<Eigen::Ref<Eigen::MatrixXf>>(corner).info() != Eigen::Success) return false;
    for_panels(rest, size, jobs, [&](Eigen::Index first, Eigen::Index rows) {
      auto below = A.block(first, k, rows, width);
      corner.triangularView<Eigen::Lower>().transpose().solveInPlace<Eigen::OnTheRight>(below);
    });
    for_panels(rest, size, jobs, [&](Eigen::Index first, Eigen::Index rows) {
      const Eigen::Index columns = first + rows - rest;
      A.block(first, rest, rows, columns).noalias() -=
          A.block(first, k, rows, width) * A.block(rest, k, columns, width).transpose();
    });
  }
  return true;
}

Eigen::VectorXf lengths(const Eigen::Ref<const Eigen::MatrixXf>& samples) {
  return samples.colwise().stableNorm().transpose();
}

float median(Eigen::VectorXf x) {
  const auto middle = x.begin() + x.size() / 2;
  std::nth_element(x.begin(), middle, x.end());
  return *middle;
}

}  // namespace

std::vector<bool> outliers(const Eigen::Ref<const Eigen::MatrixXf>& samples, float times) {
  const Eigen::VectorXf length = lengths(samples);
  const float longest = times * median(length);
  std::vector<bool> out;
  for (const float l : length) out.push_back(!(l <= longest));
  return out;
}

Eigen::VectorXf sample_weights(const Eigen::Ref<const Eigen::MatrixXf>& samples) {
  const Eigen::VectorXf length = lengths(samples);
  const float longest = kOutlier * median(length);
  return (length.array() > longest).select((longest / length.array()).square(), 1.F).matrix();
}

GaussNewton::GaussNewton(Eigen::Index size)
    : F_(Eigen::MatrixXf::Zero(size, size)),
      factor_(Eigen::MatrixXf::Zero(size, size)),
      m_(Eigen::VectorXd::Zero(size)) {}

void GaussNewton::refresh(const Eigen::Ref<const Eigen::MatrixXf>& samples, int jobs) {
  const double keep = mass_ > 0 ? kMemory : 0;
  mass_ = keep * mass_ + (1 - keep);
  const Eigen::VectorXf weight =
      static_cast<float>((1 - keep) / static_cast<double>(samples.cols())) *
      sample_weights(samples);
  const Eigen::Index size = F_.rows();
  for_panels(0, size, jobs, [&](Eigen::Index first, Eigen::Index rows) {
    auto part = F_.block(first, 0, rows, first + rows);
    part *= static_cast<float>(keep);
    const Eigen::MatrixXf weighed = samples.middleRows(first, rows) * weight.asDiagonal();
    part.noalias() += weighed * samples.topRows(first + rows).transpose();
  });
  // rounding may leave a matrix of very different samples indefinite
  for (float ridge = kRidge;; ridge *= 10) {
    factor_ = F_ / static_cast<float>(mass_);
    factor_.diagonal() *= 1 + kDamping;
    factor_.diagonal().array() += ridge;
    if (factorise(factor_, jobs)) return;
  }
}

bool GaussNewton::step(const Eigen::VectorXd& gradient, double rate, const Box& box,
                       Eigen::VectorXd& x) {
  const double length = gradient.norm();
  if (!std::isfinite(length)) return false;
  ++k_;
  const double shrink = shorten_gradient(length, k_, mean_length_);
  m_ = kMomentum * m_ + (1 - kMomentum) * shrink * gradient;
  const Eigen::VectorXf m = (m_ / (1 - std::pow(kMomentum, k_))).cast<float>();
  auto L = factor_.triangularView<Eigen::Lower>();
  const Eigen::VectorXd move = L.transpose().solve(L.solve(m)).cast<double>();
  const double longest = rate * move.cwiseAbs().maxCoeff();
  const double share = longest > kLongest ? rate * kLongest / longest : rate;
  x = box.clamp(x - share * move);
  return true;
}

}  // namespace fricid::optimise
