// Weights of particles: normalisation, effective number, resampling.
#pragma once

#include <cstddef>
#include <optional>
#include <span>

namespace fricid::smc {

/// Sum of N weights w_i = exp(lw_i) and how evenly it is spread.
struct WeightSum {
  double log_sum;  ///< log sum_i w_i
  double ess;      ///< effective sample size (sum w)^2 / sum w^2, in [1, N]
};

/// W_i = w_i / sum w, computed without overflow. -inf is a weight of zero.
/// @param lw  log weights (N), finite or -inf
/// @param W   normalised weights (N), may not overlap lw
/// @return nothing when no weight is positive or one is NaN or +inf; W is then meaningless
std::optional<WeightSum> normalise(std::span<const double> lw, std::span<double> W);

/// How ancestors are drawn; all are unbiased, E[count_i] = N W_i. Ancestors come out so that
/// systematic, stratified and multinomial ones are in ascending order.
enum class Resampling {
  kSystematic,   ///< one uniform, |count_i - N W_i| < 1
  kStratified,   ///< one uniform per N-th of the unit interval
  kMultinomial,  ///< N independent draws
  kKilling,      ///< i stays with probability W_i / max W, else it is drawn anew
};

/// Uniforms on (0, 1) that drawing `count` ancestors takes.
std::size_t uniforms_needed(Resampling scheme, std::size_t count);

/// Draws ancestors from W. Indices of weight zero are never drawn. Does not allocate.
/// @param W         normalised weights (N)
/// @param uniforms  at least uniforms_needed(scheme, ancestors.size())
/// @param ancestors indices into W to fill; kKilling needs as many as W has
void resample(Resampling scheme, std::span<const double> W, std::span<const double> uniforms,
              std::span<int> ancestors);

/// A gentle alternative to `resample`, which keeps most histories: of the renewed + 1 lightest
/// particles one is drawn by weight and takes the weight of all, the others make room for `renewed`
/// copies of the heaviest, among which their weights are shared out. Unbiased: what descends from i
/// weighs W_i on average. Ancestors come out in ascending order. Does not allocate.
/// @param renewed    0 .. N - 2
/// @param u          uniform on (0, 1)
/// @param ancestors  (N)
/// @param weights    of the new particles (N), sum 1
/// @param copies     (N) workspace
void split_heaviest(std::span<const double> W, int renewed, double u, std::span<int> ancestors,
                    std::span<double> weights, std::span<int> copies);

/// The first index with W_0 + .. + W_i > u sum W: one draw from W.
int pick(std::span<const double> W, double u);

}  // namespace fricid::smc
