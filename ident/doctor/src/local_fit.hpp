// Value, slope and curvature of a signal at a sample, by a parabola through its neighbours.
#pragma once

#include <functional>
#include <vector>

#include "fricid/data/dataset.hpp"

namespace fricid::doctor {

/// Parabola c0 + c1 s + c2 s^2 with s in samples from the centre.
struct Parabola {
  double c0 = 0, c1 = 0, c2 = 0;
  double at(double s) const { return c0 + s * (c1 + s * c2); }
};

/// Least squares over `half` samples on either side of sample k (Savitzky & Golay, 1964).
/// @pre half <= k < T - half
Parabola local_fit(const data::RowMatrix& x, int column, int k, int half);

/// Mean over `half` samples on either side, three times over: no phase. Missing where any of them
/// is.
data::RowMatrix smooth(const data::RowMatrix& x, int half);

/// The motion and the torque at chosen samples, noise averaged over a few hundredths of a second.
struct Motion {
  std::vector<int> samples;            ///< (S) rows of the data set
  int half = 0;                        ///< window of the local fits, in samples
  data::RowMatrix q, v, a;             ///< (S, n) [rad], [rad/s], [rad/s^2]
  double dt = 0;                       ///< [s]
  const data::Dataset* log = nullptr;  //

  int length() const { return static_cast<int>(samples.size()); }
  /// Torque (S) of a joint, moved back in time by `delay` samples. The torque tau_k is held to the
  /// next sample, so that it belongs half a sample later than q_k.
  Eigen::VectorXd torque(int joint, double delay) const;
  /// The same with its first and second derivative by time (S, 3).
  Eigen::MatrixX3d torque_and_rates(int joint, double delay) const;
};

/// At most `count` samples spread over the log, each with finite values all about it.
/// @param half_s  half the window of the local fits [s]
/// @param margin  further samples on either side that must be finite, for `torque`
Motion local_motion(const data::Dataset& d, int count, double half_s, int margin);

/// Sums over the samples of a motion at which a joint's logged velocity w is finite.
struct VelocityProducts {
  double dot = 0, square = 0, logged = 0;  ///< w v, v^2, w^2
};

/// @param logged  velocity of joint j by the row of the log
VelocityProducts compare_velocity(const Motion& motion, int j,
                                  const std::function<double(int)>& logged);

}  // namespace fricid::doctor
