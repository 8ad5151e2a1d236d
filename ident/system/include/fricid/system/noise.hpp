// Noise of an arm and its sensors, per sample.
#pragma once

#include <Eigen/Core>

namespace fricid {

/// Change of q per change of v by a torque disturbance held over a sample [s]. An ArmStepper of m
/// substeps, at any leap, moves q with the new v, hence further than the dt/2 of continuous time:
///
///     c = dt/2 (1 + 1/m).
double position_per_velocity(double dt, int substeps);

/// Variances per sample of length dt. A torque disturbance held over a sample moves q and v
/// together:
///
///     w_v ~ N(0, v),   w_q = c w_v + N(0, q),   w_z ~ N(0, z),   e ~ N(0, R),
///
/// c as in `position_per_velocity`.
struct LatentNoise {
  double dt = 0;      ///< [s]
  Eigen::VectorXd q;  ///< (n) [rad^2], positive
  Eigen::VectorXd v;  ///< (n) [rad^2/s^2]
  Eigen::VectorXd z;  ///< (n_z) [z^2]
  Eigen::VectorXd R;  ///< (n) of the encoders [rad^2], or (2 n) if velocity is observed too, of
                      ///< which the last n in [rad^2/s^2]
  /// (n) of what the law leaves of the friction torque [(N m)^2]; empty: not known
  Eigen::VectorXd friction = {};

  /// Covariance of [w_q, w_v, w_z] for samples of `substeps` steps, (2 n + n_z) square.
  Eigen::MatrixXd Q(int substeps) const;
};

}  // namespace fricid
