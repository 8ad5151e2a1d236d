#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <span>
#include <vector>

#include "fricid/smc/kalman.hpp"
#include "fricid/smc/lanes.hpp"
#include "fricid/smc/model.hpp"
#include "fricid/smc/report.hpp"

namespace fricid::smc {

/// Normalised innovation squared of a particle filter: how far y_{t+1} lies from what the particles
/// at t predict, in units of the predicted covariance:
///     m = sum W_i F_i,   P = sum W_i (F_i - m)(F_i - m)' + Q
///     nis = (y - C m)' (C P C' + R)^-1 (y - C m)
/// with F_i = f_t(x_t^i) and W the weights of x_t given y_0 .. y_t. Chi-squared with as many
/// degrees of freedom as channels are present where the model holds and the prediction is normal.
template <class S>
class InnovationMonitor {
 public:
  template <StateSpaceModel M>
  explicit InnovationMonitor(const M& model)
      : C_(model.C()),
        R_(model.R()),
        CQC_(C_ * model.Q() * C_.transpose()),
        CPC_(C_ * model.initial().covariance * C_.transpose()),
        start_(model.initial()),
        ws_(static_cast<int>(C_.rows()), static_cast<int>(C_.rows())),
        lanes_(C_.rows(), C_.cols()),
        identity_(Eigen::MatrixXd::Identity(C_.rows(), C_.rows())),
        predicted_{Eigen::VectorXd(C_.rows()), CQC_},
        reference_(C_.rows()),
        deviation_(static_cast<std::size_t>(C_.rows()), S(0)),
        sums_(deviation_),
        products_(deviation_.size() * deviation_.size(), S(0)) {
    lanes_.assign(C_);
  }

  /// For y_0, predicted by N(m0, P0).
  void start(std::span<const double> y) {
    predicted_.mean.noalias() = C_ * start_.mean;
    predicted_.covariance = CPC_;
    last_ = kalman_update(y, identity_, R_, predicted_, ws_);
  }

  /// For y at t + 1, predicted by the images of the particles at t.
  void predict(const Cloud<S>& image, std::span<const double> W, std::span<const double> y);

  void add_to(Report& report) const {
    report.nis.push_back(last_.nis);
    report.present.push_back(last_.present);
  }

 private:
  Eigen::MatrixXd C_, R_, CQC_, CPC_;
  Gaussian start_;
  UpdateWorkspace ws_;
  LaneMatrix<S> lanes_;
  Eigen::MatrixXd identity_;
  Gaussian predicted_;
  Eigen::VectorXd reference_;
  std::vector<S> deviation_, sums_, products_;
  Innovation last_;
};

template <class S>
void InnovationMonitor<S>::predict(const Cloud<S>& image, std::span<const double> W,
                                   std::span<const double> y) {
  constexpr int kLanes = kLaneCount<S>;
  const int ny = lanes_.rows();
  const auto index = [ny](int i, int j) { return static_cast<std::size_t>(i * ny + j); };
  std::fill(sums_.begin(), sums_.end(), S(0));
  std::fill(products_.begin(), products_.end(), S(0));

  // moments of C F about those of the first particle
  for (int i = 0; i < ny; ++i) reference_(i) = lane(lanes_.add_row(i, image.block(0), S(0)), 0);
  for (int b = 0; b < image.blocks(); ++b) {
    S weight(0);
    for (int k = 0; k < kLanes; ++k) {
      const auto particle = static_cast<std::size_t>(b * kLanes + k);
      if (particle < W.size()) set_lane(weight, k, static_cast<Real<S>>(W[particle]));
    }
    const auto counted = weight > S(0);
    for (int i = 0; i < ny; ++i) {
      const S d = lanes_.add_row(i, image.block(b), S(static_cast<Real<S>>(-reference_(i))));
      const S di = select(counted, d, S(0));
      deviation_[index(0, i)] = di;
      const S weighted = weight * di;
      sums_[index(0, i)] += weighted;
      for (int j = 0; j <= i; ++j) {
        products_[index(i, j)] = fma(weighted, deviation_[index(0, j)], products_[index(i, j)]);
      }
    }
  }
  predicted_.covariance = CQC_;
  for (int i = 0; i < ny; ++i) {
    const double mean_i = add_lanes(sums_[index(0, i)]);
    predicted_.mean(i) = reference_(i) + mean_i;
    for (int j = 0; j <= i; ++j) {
      const double mean_j = add_lanes(sums_[index(0, j)]);
      const double covariance = add_lanes(products_[index(i, j)]) - mean_i * mean_j;
      predicted_.covariance(i, j) += covariance;
      if (i != j) predicted_.covariance(j, i) += covariance;
    }
  }
  last_ = kalman_update(y, identity_, R_, predicted_, ws_);
}

}  // namespace fricid::smc
