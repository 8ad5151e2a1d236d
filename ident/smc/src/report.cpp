#include "fricid/smc/report.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <span>

#include "fricid/base/upper_median.hpp"

namespace fricid::smc {
namespace {

constexpr int kFewParticles = 20;

double median(std::span<const double> values) {
  return upper_median({values.begin(), values.end()});
}

}  // namespace

void Report::reset(int T, int N) {
  failed = true;
  steps = 0;
  particles = N;
  log_likelihood = 0;
  ess.assign(static_cast<std::size_t>(T), 0);
  resampled = distinct_roots = 0;
  nis.clear();
  present.clear();
  backward_ess.clear();
  paths = path_roots = 0;
  refreshed = 0;
}

double Report::min_ess() const {
  const std::span valid(ess.data(), static_cast<std::size_t>(steps));
  return valid.empty() ? 0 : *std::min_element(valid.begin(), valid.end());
}

double Report::median_ess() const {
  return median(std::span(ess.data(), static_cast<std::size_t>(steps)));
}

double Report::median_backward_ess() const { return median(backward_ess); }

NisFigure nis_figure(std::span<const double> nis, std::span<const int> present) {
  const int channels = std::accumulate(present.begin(), present.end(), 0);
  if (channels == 0) return {1, std::numeric_limits<double>::infinity()};
  return {std::accumulate(nis.begin(), nis.end(), 0.0) / channels, 3 * std::sqrt(2.0 / channels)};
}

std::optional<Warning> NisFigure::warning() const {
  if (std::abs(mean - 1) <= half_width) return {};
  const bool large = mean > 1;
  return Warning{fmt::format("NIS per channel {:.3g}, a true model gives {:.3g} to {:.3g}", mean,
                             1 - half_width, 1 + half_width),
                 large ? "the data depart from the predictions by more than Q and R allow"
                       : "the data follow the predictions more closely than Q and R expect",
                 large ? "raise Q or improve the model; never lower Q from here" : "lower Q or R"};
}

std::vector<Warning> Report::warnings() const {
  std::vector<Warning> list;
  if (failed) {
    list.push_back({fmt::format("no particle explains observation {}", steps),
                    "every weight vanished or one is not a number; there are no estimates after it",
                    "raise Q, check the observation for outliers, bound the states"});
    return list;
  }
  if (auto warning = nis_figure(nis, present).warning()) list.push_back(std::move(*warning));
  if (particles < kFewParticles)
    list.push_back({fmt::format("{} particles", particles),
                    "means, bands and likelihood rest on too few samples",
                    "use more particles: 100 to 200 for an arm"});
  if (distinct_roots < 0.1 * particles) {
    list.push_back({fmt::format("distinct roots {} of {}", distinct_roots, particles),
                    "all particles descend from few: their histories are not smoothed paths",
                    "smooth backwards, use the twisted filter, or raise Q"});
  }
  if (!backward_ess.empty() && median_backward_ess() < 3) {
    list.push_back({fmt::format("backward ESS {:.2g}", median_backward_ess()),
                    "given its future each path has one possible past: smoothing repeats the "
                    "filter's histories",
                    "raise Q, use more particles, the twisted filter, or the Gaussian smoother"});
  }
  if (paths > 0 && refreshed < 0.2) {
    list.push_back({fmt::format("{:.2g} of the ancestors refreshed", refreshed),
                    "backward steps keep the filter's histories",
                    "raise Q, or make more moves per step"});
  }
  if (paths > 0 && path_roots < 0.1 * std::min(paths, particles)) {
    list.push_back({fmt::format("distinct roots {} of {} paths", path_roots, paths),
                    "the paths coincide near the start: their spread there is meaningless",
                    "as for a low backward ESS"});
  }
  if (min_ess() < 2) {
    list.push_back({fmt::format("smallest ESS {:.3g} of {}", min_ess(), particles),
                    "one particle carried nearly all weight at some step",
                    "look at the data there; use the adapted or twisted filter, more particles"});
  }
  return list;
}

}  // namespace fricid::smc
