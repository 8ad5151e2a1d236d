// Low-pass filters that shift no signal in time.
#pragma once

#include <array>
#include <complex>
#include <span>
#include <vector>

#include "fricid/signals/matrix.hpp"

namespace fricid::signals {

/// Fourth-order Butterworth low-pass (bilinear transform, cut-off prewarped) run forwards and
/// backwards over a finite record, so that a sinusoid of frequency f is multiplied by |H(f)|^2 and
/// not shifted:
///
///     |H(f)|^2 = 1 / (1 + (tan(pi f / rate) / tan(pi cutoff / rate))^8).
///
/// The record is extended on both sides by its odd reflection, long enough for the slowest pole to
/// decay, and every section starts in the steady state of the first value: constants and straight
/// lines pass unchanged to round-off.
class ZeroPhaseButterworth {
 public:
  /// @throws UserError unless 0 < cutoff_hz < rate_hz / 2
  ZeroPhaseButterworth(double cutoff_hz, double rate_hz);

  /// Filters x in place; S is double or a Pack of records of equal length. `work` is resized once.
  template <class S>
  void apply(std::span<S> x, std::vector<S>& work) const;

  /// Filters every column in place.
  void apply(RowMatrix& x) const;

  double gain(double frequency_hz) const;  ///< |H|^2 [1]
  double rate_hz() const { return rate_hz_; }
  double cutoff_hz() const { return cutoff_hz_; }
  int padding() const { return padding_; }  ///< samples after which the slowest pole is below 1e-15

  /// Impulse response g_d = direct [d = 0] + Re sum_i gain_i pole_i^|d|.
  struct Exponentials {
    std::array<std::complex<double>, 2> pole, gain;  ///< one of each pair of poles
    double direct;
  };
  Exponentials exponentials() const;

 private:
  struct Section {
    double b0, b1, b2, a1, a2;
  };
  template <class S>
  class Cascade;

  std::array<Section, 2> sections_;
  double warped_cutoff_, rate_hz_, cutoff_hz_;
  int padding_;
};

/// Half g_0 .. g_K of the symmetric impulse response of a zero-phase filter, truncated where 1 % of
/// its absolute sum is left, and scaled to unit gain for constants.
std::vector<double> impulse_response(const ZeroPhaseButterworth& filter);

/// Decimation factor k of a signal low-passed at cutoff_hz: two samples per period of the cut-off,
/// which lose nothing and leave residuals of white torque noise about uncorrelated.
int decimation(double dt, double cutoff_hz);

}  // namespace fricid::signals
