// From logged positions and torques to the q, v, a, tau of inverse-dynamics identification.
#pragma once

#include <array>
#include <span>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "fricid/data/dataset.hpp"

namespace fricid::estimate {

/// Fourth-order Butterworth low-pass (bilinear transform, cut-off prewarped) run forwards and
/// backwards over a finite record, so that a sinusoid of frequency f is multiplied by |H(f)|^2 and
/// not shifted:
///
///     |H(f)|^2 = 1 / (1 + (tan(pi f / rate) / tan(pi cutoff / rate))^8).
///
/// The record is continued on both sides by its odd reflection, long enough for the slowest pole to
/// forget, and every section starts in the steady state of the first value: constants and straight
/// lines pass unchanged to round-off.
class ZeroPhaseButterworth {
 public:
  /// @throws UserError unless 0 < cutoff_hz < rate_hz / 2
  ZeroPhaseButterworth(double cutoff_hz, double rate_hz);

  /// Filters x in place; S is double or a Pack of records of equal length. `work` is resized once.
  template <class S>
  void apply(std::span<S> x, std::vector<S>& work) const;

  double gain(double frequency_hz) const;   ///< |H|^2 [1]
  int padding() const { return padding_; }  ///< samples after which the slowest pole is below 1e-15

 private:
  struct Section {
    double b0, b1, b2, a1, a2;
  };
  template <class S>
  void run(std::span<S> x) const;

  std::array<Section, 2> sections_;
  double warped_cutoff_, rate_hz_;
  int padding_;
};

using UseMask = Eigen::Array<bool, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

/// One sequence as the inverse-dynamics model sees it, T samples of n joints at the log's own rate.
struct Filtered {
  std::string name;
  double dt = 0;                   ///< [s]
  Eigen::VectorXd t;               ///< (T) [s]
  data::RowMatrix q, v, a;         ///< (T, n) filtered position and its central differences
  data::RowMatrix q_wide, v_wide;  ///< (T, n) filtered kWideBand times wider; drive friction
  data::RowMatrix tau;             ///< (T, n) torque in force around t_k, filtered like q [N m]
  data::RowMatrix temperature;     ///< (T, n) [K]; 293.15 where the log has none
  UseMask use;                     ///< (T, n) rows that may enter a fit of a joint

  int length() const { return static_cast<int>(t.size()); }
  int n() const { return static_cast<int>(q.cols()); }
};

/// Friction is driven by a motion filtered at kWideBand times the cut-off: a reversal takes
/// milliseconds, and at the cut-off itself a joint that sticks would seem to creep through zero
/// speed.
inline constexpr double kWideBand = 5;

/// Cut-off of that motion [Hz]: kWideBand times `cutoff_hz`, at most 0.4 of the sample rate.
double wide_band(double cutoff_hz, double rate_hz);

/// Travel that makes a joint forget the friction state it started with [rad or m].
inline constexpr double kWashout = 5e-3;

/// Filters a data set. The torque tau_k of a log is held over [t_k, t_{k+1}), while the central
/// difference a_k averages the acceleration over (t_{k-1}, t_{k+1}) with a triangle; under held
/// torque that average belongs to (tau_{k-1} + tau_k) / 2, which is therefore what `tau` holds at
/// sample k. Missing values (NaN) are bridged by straight lines. Rows closer than 2 / cutoff_hz to
/// an end or 1 / cutoff_hz to a missing value are marked unused.
/// @throws UserError when the log is shorter than 8 / cutoff_hz or a column has no finite value
Filtered filter_dataset(const data::Dataset& dataset, double cutoff_hz);

/// Every k-th row of a signal low-passed at cutoff_hz carries all of it; k keeps two samples per
/// period of the cut-off, so that residuals of white torque noise are about independent.
int decimation(double dt, double cutoff_hz);

}  // namespace fricid::estimate
