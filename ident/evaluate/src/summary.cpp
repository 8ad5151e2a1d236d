#include <algorithm>
#include <cmath>
#include <map>

#include <fmt/format.h>

#include "fricid/base/not_finite.hpp"
#include "fricid/evaluate/evaluate.hpp"
#include "fricid/evaluate/headroom.hpp"
#include "fricid/evaluate/statistics.hpp"

namespace fricid::evaluate {
namespace {

/// Results of one name: its seeds.
using Seeds = std::vector<const ModelResult*>;

template <class Value>
std::vector<double> gather(const Seeds& seeds, const Value& value) {
  std::vector<double> values;
  for (const ModelResult* model : seeds)
    for (const RolloutScore& score : model->scores) values.push_back(value(score));
  return values;
}

/// Geometric means of q_mse at one horizon, one per seed, or per trajectory of the only seed.
std::vector<double> independent_means(const Seeds& seeds, std::size_t h) {
  std::map<int, std::vector<double>> groups;
  for (const ModelResult* model : seeds)
    for (const RolloutScore& score : model->scores)
      groups[seeds.size() > 1 ? model->seed : score.trajectory].push_back(score.error.q_mse[h]);
  std::vector<double> means;
  for (const auto& [group, values] : groups) {
    const double m = geometric_mean(values);
    if (!std::isnan(m)) means.push_back(m);
  }
  return means;
}

/// Share of the true friction's RMS, mean over the joints that have friction.
double share(const std::vector<double>& rmse, const std::vector<double>& rms) {
  std::vector<double> shares;
  for (std::size_t j = 0; j < rmse.size(); ++j)
    shares.push_back(rms[j] > 0 ? rmse[j] / rms[j] : kNan);
  return mean(shares);
}

void add_friction(Summary& summary, const Seeds& seeds,
                  std::span<const std::vector<double>> friction_rms) {
  const auto over_recordings = [&](const auto& member) {
    return mean(gather(seeds, [&](const RolloutScore& score) {
      if (score.start_s > 0 || friction_rms.empty()) return kNan;
      return share(member(score), friction_rms[static_cast<std::size_t>(score.trajectory)]);
    }));
  };
  summary.friction = over_recordings([](const RolloutScore& s) { return s.friction.all; });
  summary.friction_presliding =
      over_recordings([](const RolloutScore& s) { return s.friction.presliding; });
  summary.friction_reversal =
      over_recordings([](const RolloutScore& s) { return s.friction.reversal; });
  summary.friction_sliding =
      over_recordings([](const RolloutScore& s) { return s.friction.sliding; });
  summary.friction_rollout =
      over_recordings([](const RolloutScore& s) { return s.friction_rollout.all; });
}

Summary summary_of(const Seeds& seeds, std::size_t horizons,
                   std::span<const std::vector<double>> friction_rms) {
  const ModelResult& first = *seeds.front();
  Summary summary{};
  summary.name = first.name;
  summary.label = first.label;
  summary.is_oracle = first.is_oracle;
  summary.is_conventional = first.is_conventional;
  summary.seeds = static_cast<int>(seeds.size());
  summary.parameters = first.parameters;
  summary.stated_fit_seconds = first.stated_fit_seconds;
  summary.budget = first.budget;
  for (const ModelResult* model : seeds) {
    summary.doubts.insert(summary.doubts.end(), model->doubts.begin(), model->doubts.end());
    summary.rollouts += static_cast<int>(model->scores.size());
    for (const RolloutScore& score : model->scores) summary.diverged += score.diverged;
    if (!model->intervals) continue;
    if (!summary.intervals) summary.intervals.emplace();
    summary.intervals->add(*model->intervals);
  }
  for (std::size_t h = 0; h < horizons; ++h) {
    const auto q_mse = gather(seeds, [&](const RolloutScore& s) { return s.error.q_mse[h]; });
    const auto v_mse = gather(seeds, [&](const RolloutScore& s) { return s.error.v_mse[h]; });
    summary.q_mse_geometric_mean.push_back(geometric_mean(q_mse));
    summary.q_mse_mean.push_back(mean(q_mse));
    summary.q_mse_median.push_back(median(q_mse));
    summary.v_mse_geometric_mean.push_back(geometric_mean(v_mse));
    summary.interval_90.push_back(interval_90(independent_means(seeds, h)));
  }
  const bool any_interval =
      std::any_of(summary.interval_90.begin(), summary.interval_90.end(),
                  [](const Interval& interval) { return !std::isnan(interval.low); });
  summary.interval_over = !any_interval ? "none" : seeds.size() > 1 ? "seeds" : "trajectories";
  add_friction(summary, seeds, friction_rms);
  return summary;
}

/// Smallest geometric mean of q_mse among the models that `counts` accepts; NaN when there is none.
template <class Counts>
double best(const std::vector<Summary>& summaries, std::size_t h, const Counts& counts) {
  double smallest = kNan;
  for (const Summary& summary : summaries)
    if (counts(summary) && !(summary.q_mse_geometric_mean[h] >= smallest))
      smallest = summary.q_mse_geometric_mean[h];
  return smallest;
}

double larger(double a, double b) { return std::isnan(b) || a > b ? a : b; }

std::string why_meaningless(const Evaluation& report, std::size_t h, double min_headroom) {
  const double above_floor = report.best_conventional[h] / report.floor[h];
  if (std::isnan(above_floor) || above_floor >= min_headroom) return {};
  const char* decided = report.halving[h] == report.floor[h] ? "halving the truth's physics step"
                        : report.repeat[h] == report.floor[h]
                            ? "difference between successive periods"
                            : "oracle";
  return fmt::format(
      "{:.3g} s: the best conventional model's MSE {:.2g} rad^2 is {:.2g} x the floor {:.2g} ({}), "
      "at least {:.3g} x is needed",
      report.horizons_s[h], report.best_conventional[h], above_floor, report.floor[h], decided,
      min_headroom);
}

}  // namespace

void summarise(Evaluation& report, double min_headroom,
               std::span<const std::vector<double>> friction_rms) {
  const std::size_t horizons = report.horizons_s.size();
  std::vector<std::pair<std::string, Seeds>> names;
  for (const ModelResult& model : report.models) {
    const auto found = std::find_if(names.begin(), names.end(),
                                    [&](const auto& entry) { return entry.first == model.name; });
    if (found == names.end())
      names.push_back({model.name, {&model}});
    else
      found->second.push_back(&model);
  }
  report.summary.clear();
  for (const auto& [name, seeds] : names)
    report.summary.push_back(summary_of(seeds, horizons, friction_rms));

  // The first oracle, the simulator's own where there is one, is the reference.
  const auto reference = std::find_if(report.summary.begin(), report.summary.end(),
                                      [](const Summary& summary) { return summary.is_oracle; });
  report.oracle = reference == report.summary.end() ? std::vector<double>(horizons, kNan)
                                                    : reference->q_mse_geometric_mean;
  report.halving.resize(horizons, kNan);
  report.integration.resize(horizons, kNan);
  report.repeat.resize(horizons, kNan);
  report.floor.clear();
  report.best_conventional.clear();
  report.headroom.clear();
  report.meaningless.clear();
  for (std::size_t h = 0; h < horizons; ++h) {
    report.floor.push_back(larger(larger(report.oracle[h], report.halving[h]), report.repeat[h]));
    report.best_conventional.push_back(best(
        report.summary, h, [](const Summary& s) { return s.is_conventional && s.doubts.empty(); }));
    const double best_possible = std::isnan(report.oracle[h]) ? report.floor[h] : report.oracle[h];
    const Headroom headroom{report.best_conventional[h], best_possible};
    report.headroom.push_back(headroom.ratio());
    report.meaningless.push_back(why_meaningless(report, h, min_headroom));
    for (Summary& summary : report.summary) {
      const double error = summary.q_mse_geometric_mean[h];
      summary.ratio_to_oracle.push_back(error == report.oracle[h] ? 1 : error / report.oracle[h]);
      summary.headroom_closed.push_back(headroom.closed(error));
    }
  }
}

}  // namespace fricid::evaluate
