// A zero-phase low-pass of which only every D-th sample is wanted.
#pragma once

#include <array>
#include <complex>
#include <span>
#include <vector>

#include "fricid/signals/filter.hpp"

namespace fricid::signals {

/// The output of a zero-phase Butterworth low-pass at samples b D, b = 0, 1, .., from sums over
/// blocks of D samples. Its impulse response is a sum of decaying oscillations,
///
///     g_d = direct [d = 0] + Re sum_i c_i p_i^|d|             i = 0, 1: a pole of each section
///     S_i(b) = sum_{o < D} p_i^(D-1-o) x_{bD+o}      A_i(b) = sum_{o < D} p_i^o x_{bD+o}
///     s_i(b+1) = p_i^D s_i(b) + S_i(b)               a_i(b) = p_i^D a_i(b+1) + A_i(b)
///     y_{bD} = direct x_{bD} + Re sum_i c_i (p_i s_i(b) + a_i(b)),
///
/// so that x need not be kept: what is stored shrinks by D / `kSums`. Records end as those of
/// `ZeroPhaseButterworth::apply` do.
class DecimatedLowPass {
 public:
  static constexpr int kWeighted = 8;          ///< parts of S_0, S_1, A_0, A_1, real and imaginary
  static constexpr int kSums = kWeighted + 1;  ///< and x_{bD}
  template <class S>
  using Sums = std::array<S, kSums>;

  DecimatedLowPass(const ZeroPhaseButterworth& filter, int every);

  int every() const { return every_; }  ///< D
  /// Weights of x_{bD+o} in the first sums of block b.
  std::span<const double, kWeighted> weights(int o) const {
    return weights_[static_cast<std::size_t>(o)];
  }
  /// Whether sums say all of a record of `size` samples, and are fewer than its samples.
  bool is_of_use(int size) const { return every_ > kSums && size > padding_; }

  /// What lies in the record.
  template <class S>
  struct Record {
    int begin, end;                 ///< samples, which blocks count from sample 0
    S first, last;                  ///< x at begin and end - 1
    std::span<const Sums<S>> sums;  ///< of the blocks that hold any of its samples, x = 0 elsewhere
  };
  /// y at the first sample of every block; meaningless before `begin`. S is double or a Pack.
  /// @pre is_of_use(record.end - record.begin)
  template <class S>
  void apply(const Record<S>& record, std::span<S> y) const;

 private:
  using Complex = std::complex<double>;

  int every_, padding_;
  std::array<Complex, 2> pole_, gain_;  // p_i, c_i
  double direct_;
  std::vector<std::array<double, kWeighted>> weights_;
};

}  // namespace fricid::signals
