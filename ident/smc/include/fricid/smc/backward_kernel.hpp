#pragma once

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <algorithm>
#include <cstddef>
#include <limits>
#include <span>
#include <vector>

#include "fricid/base/math.hpp"
#include "fricid/smc/history.hpp"
#include "fricid/smc/lanes.hpp"

namespace fricid::smc {

/// Which particle at t may have led to a state x' at t + 1:
///     P(i | x') ~ w_t^i N(x'; F_i, Q),   F_i = f_t(x_t^i)
/// The squared distance is summed over differences of whitened states L^-1 F_i, Q = L L', formed
/// about F_0: nothing large cancels, and a pair costs n subtractions and n multiplications, besides
/// one exponential: 2.7 ns at n = 18, N = 200 in double with AVX-512 (BM_BackwardPair).
template <class S>
class BackwardKernel {
 public:
  BackwardKernel(const Eigen::MatrixXd& Q, int particles)
      : n_(static_cast<int>(Q.rows())),
        particles_(particles),
        inverse_L_(Eigen::MatrixXd::Identity(n_, n_)),
        whiten_(n_, n_),
        whitened_(n_, particles),
        log_weights_(static_cast<std::size_t>(whitened_.blocks()), S(0)),
        logits_(log_weights_),
        target_(static_cast<std::size_t>(n_), S(0)),
        reference_(n_),
        difference_(n_) {
    const Eigen::LLT<Eigen::MatrixXd> llt(Q);
    llt.matrixL().solveInPlace(inverse_L_);
    whiten_.assign(inverse_L_);
  }

  /// Takes the particles of step t.
  void prepare(const Slice<S>& slice) {
    constexpr int kLanes = kLaneCount<S>;
    for (int i = 0; i < n_; ++i) reference_(i) = slice.image.at(0, i);
    for (int b = 0; b < whitened_.blocks(); ++b) {
      const S* F = slice.image.block(b);
      for (int i = 0; i < n_; ++i) {
        target_[static_cast<std::size_t>(i)] = F[i] - S(static_cast<Real<S>>(reference_(i)));
      }
      S* w = whitened_.block(b);
      for (int i = 0; i < n_; ++i) w[i] = whiten_.add_row(i, target_.data(), S(0));
      S lw(-std::numeric_limits<Real<S>>::infinity());
      for (int k = 0; k < kLanes && b * kLanes + k < particles_; ++k) {
        set_lane(lw, k,
                 static_cast<Real<S>>(slice.log_weights[static_cast<std::size_t>(b * kLanes + k)]));
      }
      log_weights_[static_cast<std::size_t>(b)] = lw;
    }
  }

  /// Sets x'.
  void aim(std::span<const double> x) {
    for (int i = 0; i < n_; ++i) {
      difference_(i) = x[static_cast<std::size_t>(i)] - reference_(i);
    }
    for (int i = 0; i < n_; ++i) {
      const double w = inverse_L_.row(i).head(i + 1).dot(difference_.head(i + 1));
      target_[static_cast<std::size_t>(i)] = S(static_cast<Real<S>>(w));
    }
  }

  /// Draws a particle from P(. | x') of the last aim.
  /// @param u    uniform on (0, 1)
  /// @param ess  effective sample size of P, 0 when all its weights vanish
  /// @return an index, or -1 when all weights vanish
  int draw(double u, double& ess);

  /// |L^-1 (x' - F_i)|^2 for one particle and the x' of the last aim.
  double squared_distance(int particle) const {
    double sum = 0;
    for (int i = 0; i < n_; ++i) {
      const double d = whitened_.at(particle, i) - lane(target_[static_cast<std::size_t>(i)], 0);
      sum += d * d;
    }
    return sum;
  }

 private:
  int n_, particles_;
  Eigen::MatrixXd inverse_L_;
  LaneMatrix<S> whiten_;
  Cloud<S> whitened_;
  std::vector<S> log_weights_, logits_, target_;
  Eigen::VectorXd reference_, difference_;
};

template <class S>
int BackwardKernel<S>::draw(double u, double& ess) {
  constexpr int kLanes = kLaneCount<S>;
  constexpr auto kLowest = -std::numeric_limits<Real<S>>::infinity();
  const int blocks = whitened_.blocks();
  const S* target = target_.data();
  S largest(kLowest);
  for (int b = 0; b < blocks; ++b) {
    const S* w = whitened_.block(b);
    S sum(0);
    for (int i = 0; i < n_; ++i) {
      const S d = w[i] - target[i];
      sum = fma(d, d, sum);
    }
    const S logit = fma(S(Real<S>(-0.5)), sum, log_weights_[static_cast<std::size_t>(b)]);
    logits_[static_cast<std::size_t>(b)] = logit;
    largest = max(logit, largest);
  }
  Real<S> top = kLowest;
  for (int k = 0; k < kLanes; ++k) top = std::max(top, lane(largest, k));
  ess = 0;
  if (!(top > kLowest)) return -1;

  // weights cumulated in each lane by itself
  S sum(0), squares(0);
  for (int b = 0; b < blocks; ++b) {
    S& cumulated = logits_[static_cast<std::size_t>(b)];
    const S weight = exp(cumulated - S(top));
    sum += weight;
    squares = fma(weight, weight, squares);
    cumulated = sum;
  }
  const double total = add_lanes(sum);
  ess = total * total / static_cast<double>(add_lanes(squares));

  // the lane, then the block within it
  double rest = u * total;
  int k = 0;
  while (k + 1 < kLanes && !(rest < lane(sum, k))) rest -= lane(sum, k++);
  while (k > 0 && !(lane(sum, k) > 0)) --k;
  int low = 0, high = blocks - 1;
  const auto cumulated = [&](int b) { return lane(logits_[static_cast<std::size_t>(b)], k); };
  const double reach = std::min(rest, static_cast<double>(cumulated(high)));
  // the first block that passes `reach`; at the end, the first to arrive there
  const bool at_end = !(rest < cumulated(high));
  while (low < high) {
    const int middle = (low + high) / 2;
    const bool passes = at_end ? cumulated(middle) >= reach : cumulated(middle) > reach;
    if (passes)
      high = middle;
    else
      low = middle + 1;
  }
  return low * kLanes + k;
}

}  // namespace fricid::smc
