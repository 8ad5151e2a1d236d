// A recording: the log as read, and the filtered signals used by all methods.
#pragma once

#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "fricid/signals/dataset.hpp"
#include "fricid/signals/filter.hpp"

namespace fricid::signals {

/// Motion of n joints over T samples: zero-phase filtered positions and their central differences.
struct Motion {
  RowMatrix q;  ///< (T, n) [rad]
  RowMatrix v;  ///< (T, n) [rad/s]
  RowMatrix a;  ///< (T, n) [rad/s^2]
};

/// Bandwidth of a filtered motion.
enum class Band {
  kNarrow,  ///< to the cut-off: smooth enough for accelerations
  kWide,    ///< to `wide_band` of it, without accelerations: drives friction
};

/// Friction is driven by a motion filtered at kWideBand times the cut-off: reversals take
/// milliseconds, and filtered at the cut-off a sticking joint would appear to creep.
inline constexpr double kWideBand = 5;

/// Cut-off of that motion [Hz]: kWideBand times `cutoff_hz`, at most 0.4 of the sample rate.
double wide_band(double cutoff_hz, double rate_hz);

/// Travel after which the friction state no longer depends on its initial value [rad or m].
inline constexpr double kWashout = 5e-3;

using UseMask = Eigen::Array<bool, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

/// One recording of n joints over T samples, raw and filtered.
struct Recording {
  Dataset log;               ///< as it was read; NaN where a value is missing
  double dt = 0;             ///< [s]
  Motion narrow;             ///< filtered at the cut-off: inverse dynamics
  Motion wide;               ///< filtered at `wide_band`, without a: friction, open loops
  RowMatrix held_tau;        ///< (T, n) held over [t_k, t_{k+1}), see `held_torque` [N m]
  RowMatrix filtered_tau;    ///< (T, n) torque in force around t_k, filtered as `narrow` [N m]
  RowMatrix load;            ///< (T, n) of friction: filtered_tau, or as a model predicts it [N m]
  RowMatrix temperature;     ///< (T, n) missing values bridged; kRoomTemperature without any [K]
  UseMask use;               ///< (T, n) rows that may enter a fit of a joint's torque
  Eigen::VectorXd noise_sd;  ///< (n) noise of log.q, from its part above the wide band [rad]
  Eigen::VectorXd step;      ///< (n) least step of log.q, 0 of a joint that stands [rad]
  int motion_number = -1;    ///< recordings of one motion share it, see `mark_repeats`
  int period = 0;            ///< samples after which the motion repeats; 0: it does not

  int length() const { return static_cast<int>(held_tau.rows()); }
  int n() const { return static_cast<int>(held_tau.cols()); }
  const Motion& motion(Band band) const { return band == Band::kWide ? wide : narrow; }
};

/// Filters a log. The torque tau_k of a log is held over [t_k, t_{k+1}), while the second
/// difference of q averages the acceleration over (t_{k-1}, t_{k+1}) with a triangle; under held
/// torque that average belongs to (tau_{k-1} + tau_k) / 2. Friction, which changes within a few
/// samples where a joint reverses, is known at the samples: `narrow.a` and `filtered_tau` are what
/// has these means, to fourth order in dt (Numerov). Where a joint moves less than its encoder's
/// noise, or a step and a half, for .15 s or longer, `wide` is a straight line: under trembling of
/// .2 mrad/s, or a step to and fro each second, a bristle would lose in seconds what it holds at
/// rest. Missing values (NaN) are bridged by straight lines.
/// Rows closer than 2 / cutoff_hz to an end or 1 / cutoff_hz to a missing value are marked unused,
/// and so are those of a joint before its first kWashout of travel.
/// @throws UserError on a log shorter than 8 / cutoff_hz, a column without or with giant numbers
Recording make_recording(Dataset log, double cutoff_hz);

/// Samples (T) at which a filtered signal is made up: within 1 / cutoff_hz of a missing position or
/// torque of any joint.
std::vector<bool> beside_missing(const Dataset& log, double cutoff_hz);

/// What the encoders do not tell apart (n) [rad]: standard deviation of their noise, or of rounding
/// to their steps where that is larger.
Eigen::VectorXd resolution(const Recording& recording);

/// Samples (T, n) at which a joint moves less than its encoder's noise, or a step and a half, for
/// .15 s or longer, or whose filtered torque sees such a rest, within 1 / cutoff_hz.
UseMask at_rest(const Recording& recording, double cutoff_hz);

/// The motion that friction would see had the arm moved as `wide` says: `wide` filtered once more,
/// straight at rest as before, without accelerations.
Motion filtered_again(const Recording& recording, double cutoff_hz);

/// Motion that noise of the encoders, white and of their `resolution`, makes behind the filter of
/// `narrow`: a draw.
Motion motion_of_noise(const Recording& recording, double cutoff_hz, std::uint64_t seed);

/// q ((T - 1) factor + 1) on cubic curves through its samples, `factor` times as often.
Eigen::VectorXd between_samples(const Eigen::VectorXd& q, int factor);

/// Marks the rows of a joint before its first kWashout of travel unused.
void leave_out_run_in(Recording& recording);

/// Measured torque (T, n) [N m] with missing (NaN) values replaced by the last one, zero before the
/// first.
RowMatrix held_torque(ConstRowMatrix tau);

}  // namespace fricid::signals
