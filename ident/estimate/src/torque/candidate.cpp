#include "fricid/estimate/torque/candidate.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <numeric>
#include <utility>

namespace fricid::estimate {

namespace {

/// Student's t at the probability of one standard deviation (84.13 %), by its expansion in
/// 1/freedom: 1.82 (exact 1.84) for 1, 1.32 for 2, 1 for many.
double student(double freedom) {
  const double x = 1 / freedom;
  return 1 + x * (0.5 + x * (0.25 + x / 16));
}

}  // namespace

Difference between(const RolloutErrors& a, const RolloutErrors& b) {
  Difference out;
  // last: variance of one rollout, and of how many that is known
  double last = std::numeric_limits<double>::infinity(), last_freedom = 1;
  double variance = 0, uncertainty = 0, weight = 0;
  for (const auto list : {&RolloutErrors::seconds, &RolloutErrors::whole}) {
    std::vector<double> d(std::min((a.*list).size(), (b.*list).size()));
    if (d.empty()) continue;
    std::ranges::transform(a.*list, b.*list, d.begin(), std::minus());
    const auto count = static_cast<double>(d.size());
    const double mean = std::accumulate(d.begin(), d.end(), 0.0) / count;
    double square = 0;
    for (const double x : d) square += (x - mean) * (x - mean);
    // a single long rollout is taken to vary like one of a second, itself unknown of a single one
    if (d.size() > 1) last = square / (last_freedom = count - 1);
    variance += last / count;
    uncertainty += last / count * last / count / last_freedom;
    out.mean += mean;
    weight += 1;
  }
  out.mean /= weight;
  // degrees of freedom of a sum of variances: Welch, Biometrika 34, 1947
  const double freedom = uncertainty > 0 ? variance * variance / uncertainty : last_freedom;
  out.error = std::sqrt(variance) / weight * student(std::isfinite(freedom) ? freedom : 1);
  return out;
}

namespace {

std::ptrdiff_t fallen(const RolloutErrors& errors) {
  const double least = std::log(kFallenSquare);
  const auto falls = [least](double error) { return error >= least; };
  return std::ranges::count_if(errors.seconds, falls) + std::ranges::count_if(errors.whole, falls);
}

bool has_networks(const Arm& arm) {
  return std::ranges::any_of(arm.friction.model.parameters(), [](const auto& parameter) {
    return friction::is_weight(parameter.info.role);
  });
}

}  // namespace

std::vector<bool> eligible(std::span<const Candidate> candidates) {
  const auto best = std::ranges::min_element(candidates, {}, &Candidate::held_out);
  std::vector<bool> all;
  for (const Candidate& candidate : candidates) {
    const Difference worse = between(candidate.rollouts, best->rollouts);
    all.push_back(fallen(candidate.rollouts) <= fallen(best->rollouts) &&
                  std::isfinite(candidate.held_out) && worse.mean <= worse.error);
  }
  return all;
}

std::size_t choose(std::span<const Candidate> candidates) {
  std::vector<bool> from = eligible(candidates);
  std::vector<bool> plain = from;
  for (std::size_t i = 0; i < candidates.size(); ++i)
    plain[i] = from[i] && !has_networks(candidates[i].arm);
  if (std::ranges::count(plain, true) > 0) from = std::move(plain);
  const auto best = std::ranges::min_element(candidates, {}, &Candidate::held_out);
  auto taken = static_cast<std::size_t>(best - candidates.begin());
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < candidates.size(); ++i)
    if (from[i] && candidates[i].torque < least) {
      least = candidates[i].torque;
      taken = i;
    }
  return taken;
}

}  // namespace fricid::estimate
