#pragma once

#include <Eigen/Core>

namespace fricid::sim {

/// Finite Fourier series per joint (Swevers et al., IEEE T-RA 13(5), 1997), period 2 pi / w:
///
///     v(t) = sum_k a_k cos(k w t) + b_k sin(k w t)
///     q(t) = q0 + sum_k a_k / (k w) sin(k w t) - b_k / (k w) cos(k w t),   k = 1 .. K
struct Fourier {
  double w = 0;          ///< [rad/s]
  Eigen::VectorXd q0;    ///< (n) [rad]
  Eigen::MatrixXd a, b;  ///< (n, K) [rad/s]

  int n() const { return static_cast<int>(q0.size()); }
  int harmonics() const { return static_cast<int>(a.cols()); }
  double period() const;
};

/// Motion sampled on a grid, one column per time.
struct Motion {
  Eigen::MatrixXd q, v, a, jerk;  ///< (n, T)
};

/// Times at which series of one base frequency are sampled, with their sines and cosines.
class TimeGrid {
 public:
  TimeGrid(double w, int harmonics, Eigen::VectorXd t);
  /// `count` equal steps over one period, both ends included.
  static TimeGrid over_period(double w, int harmonics, int count);

  int size() const { return static_cast<int>(t_.size()); }
  const Eigen::VectorXd& t() const { return t_; }
  /// Samples of a series with this grid's w and K.
  Motion sample(const Fourier& series) const;

 private:
  Eigen::VectorXd t_;
  Eigen::ArrayXd kw_;              // (K) [rad/s]
  Eigen::MatrixXd cosine_, sine_;  // (K, T)
};

/// Smallest change of the coefficients after which the motion starts and ends at rest:
/// v(0) = sum a_k = 0 and dv/dt(0) = w sum k b_k = 0.
void start_at_rest(Fourier& series);

}  // namespace fricid::sim
