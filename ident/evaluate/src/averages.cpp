#include "fricid/evaluate/averages.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "fricid/evaluate/statistics.hpp"

namespace fricid::evaluate {

double overall(const Summary& summary) {
  double sum = 0;
  int count = 0;
  for (const double mse : summary.q_mse_geometric_mean)
    if (std::isfinite(mse) && mse > 0) {
      sum += std::log(mse);
      ++count;
    }
  return count > 0 ? sum / count : std::numeric_limits<double>::infinity();
}

std::vector<const Summary*> fitted_summaries(const Evaluation& evaluation) {
  std::vector<const Summary*> fitted;
  for (const Summary& summary : evaluation.summary)
    if (!summary.is_oracle) fitted.push_back(&summary);
  return fitted;
}

double mean_error(const Evaluation& evaluation, const std::string& model,
                  std::vector<double> HorizonErrors::*error, std::size_t horizon) {
  double sum = 0;
  int count = 0;
  for (const ModelResult& result : evaluation.models)
    if (result.name == model)
      for (const RolloutScore& score : result.scores)
        if (const double value = (score.error.*error)[horizon]; std::isfinite(value)) {
          sum += value;
          ++count;
        }
  return count > 0 ? sum / count : std::numeric_limits<double>::quiet_NaN();
}

std::optional<JointErrors> joint_errors(const Evaluation& evaluation, const std::string& model,
                                        std::size_t joint, std::size_t horizon, double resolution) {
  double sum = 0, least = std::numeric_limits<double>::infinity(), most = 0;
  int count = 0;
  for (const ModelResult& result : evaluation.models) {
    if (result.name != model) continue;
    for (const RolloutScore& score : result.scores) {
      const std::vector<double>& joints = score.error.q_mse_joint[horizon];
      if (joint >= joints.size() || !std::isfinite(joints[joint])) continue;
      const double mse = std::max(joints[joint], resolution * resolution);
      sum += std::log(mse);
      least = std::min(least, mse);
      most = std::max(most, mse);
      ++count;
    }
  }
  if (count == 0) return std::nullopt;
  return JointErrors{std::exp(sum / count / 2), std::sqrt(least), std::sqrt(most)};
}

double torque_left(const Evaluation& evaluation, const std::string& model) {
  std::vector<double> percent;
  for (const ModelResult& result : evaluation.models)
    if (result.name == model)
      for (const TorquePrediction& torque : result.torque)
        percent.insert(percent.end(), torque.percent_of_rms.begin(), torque.percent_of_rms.end());
  return mean(percent) / 100;
}

double fit_seconds(const Summary& summary, const std::map<std::string, double>& measured) {
  const auto found = measured.find(summary.name);
  return found == measured.end() ? summary.stated_fit_seconds : found->second;
}

std::vector<std::size_t> quoted_horizons(const std::vector<double>& horizons_s) {
  const auto second = std::ranges::find(horizons_s, 1.0);
  std::size_t first = horizons_s.size() > 2 ? 1 : 0;
  if (second != horizons_s.end()) first = static_cast<std::size_t>(second - horizons_s.begin());
  std::vector<std::size_t> quoted{first};
  if (first + 1 < horizons_s.size()) quoted.push_back(horizons_s.size() - 1);
  return quoted;
}

}  // namespace fricid::evaluate
