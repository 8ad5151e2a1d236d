#include "fricid/evaluate/torque_summary.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>

#include "fricid/evaluate/averages.hpp"

namespace fricid::evaluate {
namespace {

constexpr double kCertain = 3;  // standard errors of a drift that is there

using Values = std::vector<double>;

/// Mean over joints of the share that `part` has of `whole`, in percent of the torque's RMS.
double percent_of(const Values& part, const Values& whole, const Values& percent) {
  double sum = 0;
  int count = 0;
  for (std::size_t j = 0; j < part.size(); ++j)
    if (const double share = part[j] / whole[j] * percent[j]; std::isfinite(share)) {
      sum += share;
      ++count;
    }
  return sum / count;
}

bool is_static_law(const Evaluation& evaluation, const std::string& model) {
  bool is_static = false;
  for (const ModelResult& own : evaluation.models)
    if (own.name == model) is_static = own.is_conventional && own.friction_states == 0;
  return is_static;
}

}  // namespace

bool TorqueSummary::drifts(std::size_t joint) const {
  return std::abs(drift[joint]) > kCertain * drift_error[joint];
}

std::vector<TorqueSummary> torque_summaries(const Evaluation& evaluation) {
  std::vector<TorqueSummary> found;
  for (const Summary& summary : evaluation.summary) {
    const auto mean = [&](auto list) { return mean_of_torque(evaluation, summary.name, list); };
    const auto regime = [&](Values RegimeError::*list) {
      return mean(
          [list](const TorquePrediction& torque) -> const Values& { return torque.rmse.*list; });
    };
    TorqueSummary own;
    own.percent = mean(&TorquePrediction::percent_of_rms);
    if (own.percent.empty()) continue;
    own.model = summary.name;
    own.trusted = summary.doubts.empty();
    own.is_static_law = is_static_law(evaluation, summary.name);
    const Values all = regime(&RegimeError::all);
    own.reversal = percent_of(regime(&RegimeError::reversal), all, own.percent);
    own.presliding = percent_of(regime(&RegimeError::presliding), all, own.percent);
    own.sliding = percent_of(regime(&RegimeError::sliding), all, own.percent);
    own.one_step = percent_of(mean(&TorquePrediction::one_step), all, own.percent);
    own.drift = mean(&TorquePrediction::drift);
    own.drift_error = mean(&TorquePrediction::drift_error);
    found.push_back(std::move(own));
  }
  return found;
}

std::vector<double> least_percent(const std::vector<TorqueSummary>& models) {
  Values least;
  for (const TorqueSummary& model : models) {
    least.resize(model.percent.size(), INFINITY);
    for (std::size_t j = 0; j < least.size(); ++j) least[j] = std::min(least[j], model.percent[j]);
  }
  return least;
}

std::vector<TorqueSummary> trusted(const std::vector<TorqueSummary>& models) {
  std::vector<TorqueSummary> found;
  std::ranges::copy_if(models, std::back_inserter(found), &TorqueSummary::trusted);
  return found;
}

std::vector<TorqueSummary> static_laws(const std::vector<TorqueSummary>& models) {
  std::vector<TorqueSummary> found;
  std::ranges::copy_if(models, std::back_inserter(found), &TorqueSummary::is_static_law);
  return found;
}

int joints_below(const TorqueSummary& model, const std::vector<double>& least) {
  int below = 0;
  for (std::size_t j = 0; j < least.size(); ++j) below += model.percent[j] < least[j];
  return below;
}

}  // namespace fricid::evaluate
