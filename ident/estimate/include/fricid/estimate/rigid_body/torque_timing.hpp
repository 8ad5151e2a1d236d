// When the torque of a log's row acts: from its sample on, or at it.
#pragma once

#include <optional>
#include <span>

#include "fricid/estimate/rigid_body/least_squares.hpp"

namespace fricid::estimate {

/// How much later than a held one the torque of a log is.
struct TorqueTiming {
  double delay = 0, standard_error = 0;  ///< [samples]
  /// What the delay explains: sum over the joints of the log of the factor by which the variance of
  /// the residual falls.
  double gain = 0;

  /// Whether the torque is measured at its samples, which is half a sample later: within a quarter
  /// of a sample by three standard errors, and with a gain of .1. Friction that lags looks like a
  /// delay of milliseconds.
  bool is_at_samples() const;
  /// How likely it is, held and measured being as likely beforehand.
  /// @param dt  of the log [s]; friction that lags shifts the delay by about a millisecond
  double likelihood_at_samples(double dt) const;
};

/// The regression of `rigid_body_least_squares`, without a prior, with a delay d of the torque that
/// the joints have in common,
///
///     tau_j = Y_j(q, v, a) pi + Fc_j F[sign v_j] + Fv_j v_j + offset_j - d dtau_j/dk + e_j,
///
/// k counting samples, dtau/dk being that of the torque that the regression without d predicts: the
/// noise of the measured one would make d too small. Its standard error is that of the jackknife
/// over blocks of time.
/// @return nothing where there are fewer than ten rows for each unknown
std::optional<TorqueTiming> torque_timing(const dynamics::RobotModel& robot,
                                          std::span<const signals::Recording> recordings,
                                          const RigidBodyOptions& options);

}  // namespace fricid::estimate
