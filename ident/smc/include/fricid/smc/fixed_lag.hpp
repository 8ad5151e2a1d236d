#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

#include "fricid/smc/model.hpp"
#include "fricid/smc/particle_filter.hpp"

namespace fricid::smc {

/// Means and variances of the states given observations up to `lag` steps later.
struct FixedLagEstimate {
  RowMatrix mean;      ///< (T x n)
  RowMatrix variance;  ///< (T x n)
};

/// Fixed-lag smoothing (Kitagawa & Sato 2001): x_t estimated by the ancestors at t of the particles
/// at t + lag under the weights there, which a guide with foresight gives one observation more.
/// Right as long as the lag is longer than the memory of the model and shorter than the time in
/// which the particles' ancestors coincide. Memory O(N lag).
template <StateSpaceModel M, Guide G>
class FixedLagSmoother {
 public:
  using S = typename G::Lanes;

  FixedLagSmoother(ParticleFilter<M, G>& filter, int lag)
      : filter_(&filter),
        lag_(lag),
        n_(filter.model().state_size()),
        clouds_(static_cast<std::size_t>(lag + 1), filter.x()),
        ancestors_(static_cast<std::size_t>(lag + 1),
                   std::vector<int>(static_cast<std::size_t>(filter.particles()))),
        index_(ancestors_.front()) {}

  /// Runs the filter over all observations.
  /// @return false when all weights vanished at some step
  bool run(FixedLagEstimate& estimate) {
    const int T = filter_->steps();
    estimate.mean.resize(T, n_);
    estimate.variance.resize(T, n_);
    filter_->start();
    for (int t = 0; t < T; ++t) {
      cloud(t) = filter_->x();
      if (!filter_->weigh(t)) return false;
      if (t >= lag_ && t + 1 < T) record(t, t - lag_, estimate);
      if (t + 1 == T) break;
      filter_->move(t);
      std::copy(filter_->ancestors().begin(), filter_->ancestors().end(), parents(t).begin());
    }
    for (int t = std::max(0, T - 1 - lag_); t < T; ++t) record(T - 1, t, estimate);
    return true;
  }

 private:
  Cloud<S>& cloud(int t) { return clouds_[static_cast<std::size_t>(t % (lag_ + 1))]; }
  std::vector<int>& parents(int t) { return ancestors_[static_cast<std::size_t>(t % (lag_ + 1))]; }

  /// Estimates x_t with the weights at `now`.
  void record(int now, int t, FixedLagEstimate& estimate) {
    const auto W = filter_->weights();
    for (std::size_t i = 0; i < index_.size(); ++i) index_[i] = static_cast<int>(i);
    for (int u = now - 1; u >= t; --u) {
      for (int& i : index_) i = parents(u)[static_cast<std::size_t>(i)];
    }
    const Cloud<S>& x = cloud(t);
    for (int k = 0; k < n_; ++k) {
      double mean = 0, square = 0;
      const double reference = x.at(0, k);
      for (std::size_t i = 0; i < index_.size(); ++i) {
        const double d = x.at(index_[i], k) - reference;
        mean += W[i] * d;
        square += W[i] * d * d;
      }
      estimate.mean(t, k) = reference + mean;
      estimate.variance(t, k) = std::max(0.0, square - mean * mean);
    }
  }

  ParticleFilter<M, G>* filter_;
  int lag_, n_;
  std::vector<Cloud<S>> clouds_;
  std::vector<std::vector<int>> ancestors_;
  std::vector<int> index_;
};

}  // namespace fricid::smc
