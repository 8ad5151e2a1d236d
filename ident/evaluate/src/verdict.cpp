#include "fricid/evaluate/verdict.hpp"

#include <algorithm>
#include <cmath>

#include "fricid/base/not_finite.hpp"
#include "fricid/evaluate/averages.hpp"

namespace fricid::evaluate {
namespace {

constexpr double kClearlyBelow = 0.95;  // share of the best model's MSE
constexpr double kMoved = 3;            // standard errors

}  // namespace

const std::string& label_of(const Summary& summary) {
  return summary.label.empty() ? summary.name : summary.label;
}

std::vector<const Summary*> trusted_summaries(const Evaluation& evaluation) {
  std::vector<const Summary*> trusted = fitted_summaries(evaluation);
  std::erase_if(trusted, [](const Summary* summary) { return !summary->doubts.empty(); });
  return trusted;
}

const Summary* best_model(const Evaluation& evaluation) {
  const std::vector<const Summary*> trusted = trusted_summaries(evaluation);
  if (trusted.empty()) return nullptr;
  return *std::ranges::min_element(trusted, {},
                                   [](const Summary* summary) { return overall(*summary); });
}

std::vector<const Summary*> better_at_a_horizon(const Evaluation& evaluation, const Summary& best) {
  std::vector<const Summary*> better;
  for (std::size_t h = 0; h < evaluation.horizons_s.size(); ++h)
    for (const Summary* other : trusted_summaries(evaluation))
      if (other->q_mse_geometric_mean[h] < kClearlyBelow * best.q_mse_geometric_mean[h] &&
          std::ranges::none_of(
              better, [&](const Summary* known) { return label_of(*known) == label_of(*other); }))
        better.push_back(other);
  return better;
}

const Summary* best_with_band(const Evaluation& evaluation) {
  const Summary* best = nullptr;
  double least = kInfinity;
  for (const Summary* summary : fitted_summaries(evaluation)) {
    if (summary->band_coverage.empty() || !(summary->q_mse_geometric_mean.back() < least)) continue;
    best = summary;
    least = summary->q_mse_geometric_mean.back();
  }
  return best;
}

Failures failures_of(const Evaluation& evaluation, std::span<const data::FitFile* const> fits) {
  Failures failures;
  for (const Summary* summary : fitted_summaries(evaluation))
    if (summary->diverged > 0) failures.diverging.push_back(summary);
  for (const data::FitFile* fit : fits) {
    failures.unusable_fits += !fit->usable;
    failures.limited_fits += fit->outcome == data::Outcome::kIterationLimit;
    for (const data::FittedJoint& joint : fit->joints)
      failures.at_bound += static_cast<int>(joint.at_bound.size());
  }
  for (std::size_t h = 0; h < evaluation.horizons_s.size(); ++h)
    if (!evaluation.meaningless[h].empty())
      failures.blind_horizons.push_back(evaluation.horizons_s[h]);
  return failures;
}

std::vector<JointVerdict> joint_verdicts(std::span<const std::string> joints,
                                         std::span<const LabelledFit> fits) {
  std::vector<JointVerdict> verdicts;
  for (std::size_t j = 0; j < joints.size(); ++j) {
    std::vector<double> r2;
    JointVerdict own{.joint = joints[j], .least_r2 = kNan, .most_r2 = kNan, .model = {}};
    for (const auto& [label, fit] : fits) {
      if (j < fit->joints.size()) r2.push_back(fit->joints[j].r2);
      for (const data::FittedFault& fault : fit->faults)
        if (fault.joint == own.joint && own.fault == nullptr) {
          own.fault = &fault;
          own.model = label;
        }
    }
    if (r2.empty() && own.fault == nullptr) continue;
    if (!r2.empty()) {
      own.least_r2 = std::ranges::min(r2);
      own.most_r2 = std::ranges::max(r2);
    }
    verdicts.push_back(std::move(own));
  }
  return verdicts;
}

bool is_moved_by_physics(const data::FittedBaseParameter& parameter) {
  return std::abs(parameter.value - parameter.physical) > kMoved * parameter.standard_error;
}

}  // namespace fricid::evaluate
