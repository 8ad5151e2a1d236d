// Summary statistics of errors that spread over orders of magnitude. NaN entries are left out.
#pragma once

#include <span>

namespace fricid::evaluate {

/// exp of the mean logarithm; 0 when any value is 0, NaN when there is none.
double geometric_mean(std::span<const double> values);
double mean(std::span<const double> values);
double median(std::span<const double> values);

/// Quantile p in (0, 1) of Student's t distribution with `dof` >= 1 degrees of freedom, to
/// rounding.
double student_t_quantile(double p, int dof);

struct Interval {
  double low, high;
};

/// 90 % Student t interval of the geometric mean, on logarithms; NaN with fewer than two values.
Interval interval_90(std::span<const double> values);

}  // namespace fricid::evaluate
