#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <span>
#include <vector>

#include "fricid/smc/kalman.hpp"

namespace fricid::smc::test {

/// A mean over independent replications and its standard error.
class Mean {
 public:
  void add(double x) { sum_ += x, square_ += x * x, ++count_; }
  double value() const { return sum_ / count_; }
  double standard_error() const {
    return std::sqrt((square_ / count_ - value() * value()) / (count_ - 1));
  }
  double z(double expected) const { return (value() - expected) / standard_error(); }

 private:
  double sum_ = 0, square_ = 0;
  int count_ = 0;
};

/// Compares means, covariances and lag-one covariances of sampled paths with those of a smoother,
/// in standard errors over independent replications. Two states.
class PathMoments {
 public:
  explicit PathMoments(const GaussianPath& path)
      : path_(&path), sums_(static_cast<std::size_t>(path.steps()) * kMoments) {}

  /// One replication: any number of paths that need not be independent.
  void add(std::span<const RowMatrix> paths) {
    const int T = path_->steps();
    for (int t = 0; t < T; ++t) {
      for (int k = 0; k < kMoments; ++k) {
        if (t + 1 == T && k >= 5) continue;
        double mean = 0;
        for (const RowMatrix& x : paths) mean += moment(x, t, k);
        sums_[static_cast<std::size_t>(t * kMoments + k)].add(mean /
                                                              static_cast<double>(paths.size()));
      }
    }
  }

  void expect_smoothed(double limit = 4.5) const {
    const int T = path_->steps();
    for (int t = 0; t < T; ++t) {
      const auto u = static_cast<std::size_t>(t);
      const Eigen::MatrixXd& P = path_->smoothed[u].covariance;
      std::vector<double> expected = {0, 0, P(0, 0), P(0, 1), P(1, 1)};
      if (t + 1 < T) {
        const Eigen::MatrixXd& L = path_->lag_one[u];
        expected.insert(expected.end(), {L(0, 0), L(0, 1), L(1, 0), L(1, 1)});
      }
      for (std::size_t k = 0; k < expected.size(); ++k) {
        EXPECT_LT(std::abs(sums_[u * kMoments + k].z(expected[k])), limit)
            << "t = " << t << ", moment " << k;
      }
    }
  }

 private:
  static constexpr int kMoments = 9;

  double moment(const RowMatrix& x, int t, int k) const {
    const auto d = [&](int step, int i) {
      return x(step, i) - path_->smoothed[static_cast<std::size_t>(step)].mean(i);
    };
    if (k < 2) return d(t, k);
    if (k < 5) return d(t, (k - 2) / 2) * d(t, (k - 1) / 2);
    return d(t + 1, (k - 5) / 2) * d(t, (k - 5) % 2);
  }

  const GaussianPath* path_;
  std::vector<Mean> sums_;
};

}  // namespace fricid::smc::test
