#include "fricid/evaluate/statistics.hpp"
#include "fricid/base/not_finite.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

namespace fricid::evaluate {
namespace {

std::vector<double> without_nan(std::span<const double> values) {
  std::vector<double> kept;
  for (const double value : values)
    if (!std::isnan(value)) kept.push_back(value);
  return kept;
}

/// Probability that |T| < t for Student's t with `dof` degrees of freedom, as a finite series in
/// angle = atan(t / sqrt(dof)) (Abramowitz & Stegun 26.7.3 and 26.7.4).
double student_t_inside(double t, int dof) {
  const double angle = std::atan(t / std::sqrt(dof)), c = std::cos(angle), s = std::sin(angle);
  const bool odd = dof % 2 == 1;
  double sum = 0, term = odd ? c : 1;
  for (int k = odd ? 1 : 0; k <= dof - 2; k += 2) {
    sum += term;
    term *= c * c * (k + 1) / (k + 2);
  }
  return odd ? (angle + s * sum) * 2 * std::numbers::inv_pi : s * sum;
}

}  // namespace

double mean(std::span<const double> values) {
  const std::vector<double> kept = without_nan(values);
  if (kept.empty()) return kNan;
  double sum = 0;
  for (const double value : kept) sum += value;
  return sum / static_cast<double>(kept.size());
}

double geometric_mean(std::span<const double> values) {
  std::vector<double> logs;
  for (const double value : values) logs.push_back(std::log(value));
  return std::exp(mean(logs));
}

double median(std::span<const double> values) {
  std::vector<double> kept = without_nan(values);
  if (kept.empty()) return kNan;
  std::sort(kept.begin(), kept.end());
  const std::size_t half = kept.size() / 2;
  return kept.size() % 2 ? kept[half] : (kept[half - 1] + kept[half]) / 2;
}

double student_t_quantile(double p, int dof) {
  if (p < 0.5) return -student_t_quantile(1 - p, dof);
  const double inside = 2 * p - 1;
  double low = 0, high = 1;
  while (student_t_inside(high, dof) < inside) high *= 2;
  while (true) {
    const double middle = low + (high - low) / 2;
    if (middle <= low || middle >= high) return middle;
    (student_t_inside(middle, dof) < inside ? low : high) = middle;
  }
}

Interval interval_90(std::span<const double> values) {
  if (values.size() < 2) return {kNan, kNan};
  std::vector<double> logs;
  for (const double m : values) logs.push_back(std::log(m));
  const double centre = mean(logs);
  double squares = 0;
  for (const double log : logs) squares += (log - centre) * (log - centre);
  const auto count = static_cast<double>(logs.size());
  const double half = student_t_quantile(0.95, static_cast<int>(logs.size()) - 1) *
                      std::sqrt(squares / (count - 1) / count);
  return {std::exp(centre - half), std::exp(centre + half)};
}

}  // namespace fricid::evaluate
