// How even sample times are: one measure for the reader, which refuses uneven times, and for the
// doctor, which reports and repairs them.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "fricid/data/dataset.hpp"

namespace fricid::data {

inline constexpr double kGap = 1.5;          ///< periods: between such samples some may be lost
inline constexpr double kUnevenness = 0.01;  ///< of the period: what even times may be off

/// Whether two samples are one period apart, within `kUnevenness`.
bool is_one_period(double dt, double rate_hz);

/// Whether the stamp of row k alone is ahead: the next ones go on from the one before it.
bool is_ahead_alone(const Eigen::VectorXd& t, int k);

/// Rows whose stamps rise: without repeats, and without a single stamp that is ahead of the next.
std::vector<int> rising_rows(const Eigen::VectorXd& t);

/// All rows by their stamps, those of one stamp as they were.
std::vector<int> order_by_time(const Eigen::VectorXd& t);

/// Samples lost before each row (T), by rising times: a stamp that is late alone is jitter; after a
/// gap those that follow are late too.
std::vector<int> lost_before(const Eigen::VectorXd& t, double rate_hz);

/// Rate of the samples: the slope of the line through all stamps that rise, gaps closed. Stamps
/// that are late do not change it, as a mean of those periods that look regular would.
/// @param rate_hz  the rate, roughly
double rate_by_line(const Eigen::VectorXd& t, double rate_hz);

/// A clock with fewer steps than there are samples: some stamps equal the one before, all others
/// are whole steps later.
struct CoarseClock {
  double step_s = 0;
  double rate_hz = 0;      ///< of the line through the stamps
  bool fits_even = false;  ///< no stamp is off that line by more than a step: no sample is missed
};
/// @param d  of which the rate is not used
/// @return none where most rows of one stamp are copies, which are repeats, or hardly any are
std::optional<CoarseClock> coarse_clock(const Dataset& d);

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
