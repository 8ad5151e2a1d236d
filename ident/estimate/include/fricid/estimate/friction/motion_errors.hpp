// What a joint's friction torque errs by because its motion is filtered and sampled.
#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "fricid/estimate/friction/friction_fit.hpp"
#include "fricid/signals/recording.hpp"

namespace fricid::estimate {

/// Friction is driven by a motion that lacks what the filter took and what was between the samples,
/// in every recording alike: no resampling of the data shows what that does to a parameter. About
/// as much is shown by making the one once more and the other less,
///
///     2 (F[f(q between the samples)] - F[f(q filtered again)]).
///
/// A second filter finds less to take than the first, and a curve through samples is smoother than
/// the motion was: hence the 2, which is measured (docs/method.md#errors-of-parameters).
class MotionErrors {
 public:
  /// Of recordings that stay and whose motion does not change; their load may.
  MotionErrors(std::span<const signals::Recording> recordings, double cutoff_hz, int jobs);

  /// (rows) error of F[f] at the samples row[s] of every sequence [N m].
  /// @param data  of the same recordings and of `joint`
  Eigen::VectorXd of(const JointFrictionData& data, int joint,
                     const friction::RobotFriction& friction, std::span<const double> theta,
                     std::span<const std::vector<int>> row) const;

 private:
  std::span<const signals::Recording> recordings_;
  std::vector<signals::Motion> again_;  // of each, filtered again
  double cutoff_hz_;
};

}  // namespace fricid::estimate
