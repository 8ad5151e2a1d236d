#include "fricid/estimate/torque/candidate.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <numeric>
#include <tuple>
#include <utility>

namespace fricid::estimate {

Difference between(const RolloutErrors& a, const RolloutErrors& b) {
  Difference out;
  double variance = 0, weight = 0,
         last = std::numeric_limits<double>::infinity();  // last: variance of one rollout
  for (const auto list : {&RolloutErrors::seconds, &RolloutErrors::whole}) {
    std::vector<double> d(std::min((a.*list).size(), (b.*list).size()));
    if (d.empty()) continue;
    std::ranges::transform(a.*list, b.*list, d.begin(), std::minus());
    const auto count = static_cast<double>(d.size());
    const double mean = std::accumulate(d.begin(), d.end(), 0.0) / count;
    double square = 0;
    for (const double x : d) square += (x - mean) * (x - mean);
    // a single long rollout is taken to vary like one of a second, itself unknown of a single one
    if (d.size() > 1) last = square / (count - 1);
    variance += last / count;
    out.mean += mean;
    weight += 1;
  }
  out.mean /= weight;
  out.error = std::sqrt(variance) / weight;
  return out;
}

bool has_networks(const Arm& arm) {
  return std::ranges::any_of(arm.friction.model.parameters(), [](const auto& parameter) {
    return friction::is_weight(parameter.info.role);
  });
}

namespace {

constexpr int kFewRollouts = 10;  // of a second: their differences
constexpr double kChance = 3;     // below this factor are taken for chance
// Held-out torques that are one: they were seen, and a law with more parameters lowers them anyway.
constexpr double kTie = 1.03, kTieOfFew = 1.06;  // the latter of laws, where rollouts are few
// Rollouts that few samples of the torque agree with are good by chance.
constexpr double kMostTorque = 4;  // of the least held-out torque error
constexpr double kNoRollout = 30;  // times the best rollout error [rad^2]: such torque says nothing

bool few_rollouts(const Candidate& candidate) {
  return std::ssize(candidate.rollouts.seconds) < kFewRollouts;
}

/// Rollouts that fell. Where there are few, one of full length may have fallen by chance: an arm
/// that no gravity brings back departs with time.
std::ptrdiff_t fallen(const Candidate& candidate) {
  const auto falls = [least = std::log(kFallenSquare)](double error) { return error >= least; };
  const std::ptrdiff_t seconds = std::ranges::count_if(candidate.rollouts.seconds, falls),
                       whole = std::ranges::count_if(candidate.rollouts.whole, falls);
  return seconds + std::max<std::ptrdiff_t>(0, whole - (few_rollouts(candidate) ? 1 : 0));
}

/// Whether a candidate explains the held-out torque as others do.
std::vector<bool> explains(std::span<const Candidate> candidates) {
  const double best = std::ranges::min_element(candidates, {}, &Candidate::held_out)->held_out;
  const auto error = [best](const Candidate& candidate) {
    return std::pair(!(candidate.held_out <= kNoRollout * best), candidate.torque);
  };
  const double least = std::ranges::min_element(candidates, {}, error)->torque;
  std::vector<bool> out;
  for (const Candidate& candidate : candidates)
    out.push_back(candidate.torque <= kMostTorque * least);
  return out;
}

/// The best rollouts among the candidates that explain the torque, or among all where those fall
/// more often.
std::size_t best_of(std::span<const Candidate> candidates) {
  const std::vector<bool> explaining = explains(candidates);
  std::size_t best = 0, explained = candidates.size();
  for (std::size_t i = 0; i < candidates.size(); ++i) {
    const auto better = [&](std::size_t than) {
      return than == candidates.size() || candidates[i].held_out < candidates[than].held_out;
    };
    if (better(best)) best = i;
    if (explaining[i] && better(explained)) explained = i;
  }
  const bool all =
      explained == candidates.size() || fallen(candidates[explained]) > fallen(candidates[best]);
  return all ? best : explained;
}

}  // namespace

std::vector<bool> eligible(std::span<const Candidate> candidates) {
  std::vector<bool> all;
  if (candidates.empty()) return all;
  const std::size_t first = best_of(candidates);
  const Candidate& best = candidates[first];
  const std::vector<bool> explaining = explains(candidates);
  for (std::size_t i = 0; i < candidates.size(); ++i) {
    const Candidate& candidate = candidates[i];
    const Difference worse = between(candidate.rollouts, best.rollouts);
    all.push_back(fallen(candidate) <= fallen(best) && std::isfinite(candidate.held_out) &&
                  (explaining[i] || !explaining[first]) &&
                  worse.mean <= (few_rollouts(candidate) ? std::max(worse.error, std::log(kChance))
                                                         : worse.error));
  }
  return all;
}

bool explains_far_more(const Candidate& a, const Candidate& b) {
  const Difference worse = between(a.rollouts, b.rollouts);
  return kMostTorque * a.torque < b.torque && fallen(a) <= fallen(b) && worse.mean <= worse.error;
}

namespace {

/// Of some candidates the one with fewest parameters among the least held-out torque error and what
/// is near it; of as many, the one with the best rollouts. @pre there is one
std::size_t simplest(std::span<const Candidate> candidates, const std::vector<std::size_t>& some,
                     double tie) {
  const auto torque = [&](std::size_t i) { return candidates[i].torque; };
  const double most = tie * torque(*std::ranges::min_element(some, {}, torque));
  return *std::ranges::min_element(some, {}, [&](std::size_t i) {
    return std::tuple(torque(i) > most, candidates[i].parameters, candidates[i].held_out);
  });
}

}  // namespace

std::size_t choose(std::span<const Candidate> candidates) {
  const std::vector<bool> from = eligible(candidates);
  std::vector<std::size_t> all, sums, rivals;
  for (std::size_t i = 0; i < candidates.size(); ++i) {
    if (!from[i]) continue;
    all.push_back(i);
    (candidates[i].rival ? rivals : sums).push_back(i);
  }
  if (all.empty()) return best_of(candidates);
  if (!few_rollouts(candidates[all.front()])) return simplest(candidates, all, kTie);
  // neither the torque nor the rollouts of a few seconds tell a sum from a law
  const auto product = [&](std::size_t i) { return candidates[i].torque * candidates[i].held_out; };
  if (!rivals.empty()) sums.push_back(simplest(candidates, rivals, kTieOfFew));
  return *std::ranges::min_element(sums, {}, product);
}

}  // namespace fricid::estimate
