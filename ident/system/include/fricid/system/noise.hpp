// Noise of an arm and its sensors, per sample.
#pragma once

#include <Eigen/Core>

namespace fricid {

/// Variances per sample of length dt. What disturbs the torque for a sample moves q by half of what
/// it moves v times dt:
///
///     w_v ~ N(0, v),   w_q = dt/2 w_v + N(0, q),   w_z ~ N(0, z),   e ~ N(0, R).
struct LatentNoise {
  double dt = 0;      ///< [s]
  Eigen::VectorXd q;  ///< (n) [rad^2], small and positive
  Eigen::VectorXd v;  ///< (n) [rad^2/s^2]
  Eigen::VectorXd z;  ///< (n_z) [z^2]
  Eigen::VectorXd R;  ///< (n) of the encoders [rad^2], or (2 n) when velocity is observed too

  /// Covariance of [w_q, w_v, w_z], (2 n + n_z) square.
  Eigen::MatrixXd Q() const;
};

}  // namespace fricid
