// How even sample times are: one measure for the reader, which refuses uneven times, and for the
// doctor, which reports and repairs them.
#pragma once

#include <Eigen/Core>

namespace fricid::data {

inline constexpr double kGap = 1.5;          ///< periods: between such samples some may be lost
inline constexpr double kUnevenness = 0.01;  ///< of the period: what even times may be off

/// Whether two samples are one period apart, within `kUnevenness`.
bool is_one_period(double dt, double rate_hz);

/// What a clock does over a log, seen in its periods that are neither gaps nor repeats.
struct ClockQuality {
  double jitter_s = 0;  ///< rms of the periods about their mean in a tenth of the log
  double drift = 0;     ///< range of those means, as a share of the period
  bool drifts = false;  ///< more than jitter explains
};
ClockQuality quality_of_clock(const Eigen::VectorXd& t, double rate_hz);

/// Whether times jitter so little that they are the times of even samples, stamped a little late:
/// uneven, but nothing is lost or repeated, no period is off by more than 20 %, 3 % rms, and the
/// clock does not drift.
bool is_slight_jitter(const Eigen::VectorXd& t, double rate_hz);

}  // namespace fricid::data
