#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "figure_parts.hpp"
#include "fricid/evaluate/averages.hpp"
#include "fricid/evaluate/metrics.hpp"
#include "fricid/evaluate/verdict.hpp"

namespace fricid::render {
namespace {

constexpr double kSmallest = 1e-9;  // [rad] bottom of a log axis, below the resolution of encoders
constexpr int kCross = 2;           // marker of gnuplot
constexpr double kRoom = 0.5;       // of the range of the motion, on either side

/// Samples of an open loop up to that at which it fell, from where its positions are constant.
Eigen::Index length_to_fall(const RowMatrix& q) {
  Eigen::Index length = q.rows();
  while (length > 1 && q.row(length - 1) == q.row(length - 2)) --length;
  return length;
}

}  // namespace

Figure tracking(const Run& run) {
  Figure figure{.name = "tracking"};
  figure.caption = fmt::format(
      "Open loop on {}: every model starts at the measured state and is driven by the measured "
      "motor torque alone. Black: measured position. A cross: there the open loop fell, and was "
      "ended.",
      run.trajectory);
  for (int j = 0; j < run.n(); ++j)
    figure.panels.push_back({.title = run.joint(j),
                             .x_label = "t [s]",
                             .y_label = fmt::format("q [{}]", run.units(j).q),
                             .fit_x = true});
  for (const RunModel& model : run.fitted()) {
    const auto rollout = run.rollout(model);
    if (!rollout) continue;
    const evaluate::Summary* summary = run.summary(model.name);
    const bool may_fall = summary != nullptr && summary->diverged > 0;
    const Eigen::Index length = may_fall ? length_to_fall(rollout->q) : rollout->q.rows();
    for (int j = 0; j < run.n(); ++j) {
      Panel& panel = figure.panels[static_cast<std::size_t>(j)];
      panel.series.push_back(curve(model, rollout->t.head(length), rollout->q.col(j).head(length)));
      if (length == rollout->q.rows()) continue;
      // what fell far away would flatten the others
      const double low = run.measured.q.col(j).minCoeff(), high = run.measured.q.col(j).maxCoeff();
      panel.y_range = {low - kRoom * (high - low), high + kRoom * (high - low)};
      panel.series.push_back(
          {.colour = model.look.colour,
           .x = {rollout->t[length - 1]},
           .y = {std::clamp(rollout->q(length - 1, j), panel.y_range.low, panel.y_range.high)},
           .mark = Mark::kPoints,
           .marker = kCross});
    }
  }
  for (int j = 0; j < run.n(); ++j)
    figure.panels[static_cast<std::size_t>(j)].series.push_back(
        curve("measured", kMeasuredColour, run.measured.t, run.measured.q.col(j)));
  return figure;
}

Figure bands(const Run& run) {
  Figure figure{.name = "bands"};
  const evaluate::Summary* summary = evaluate::best_with_band(run.evaluation);
  const RunModel* best = summary == nullptr ? nullptr : run.model(summary->name);
  if (best == nullptr) return figure;
  const std::optional<evaluate::BandSignals> signals = run.band(*best);
  if (!signals) return figure;

  figure.caption = fmt::format(
      "Open loop of {} on {} and its 90 % band, less the measured position, which is the black "
      "line at zero: the band covers the motion where it holds that line. Over all trajectories "
      "{:.0f} % of the samples of q lie in their band.",
      best->label, run.trajectory, 100 * summary->band_coverage.back());
  const Eigen::VectorXd& t = signals->t;
  const evaluate::Band& limits = signals->band;
  for (int j = 0; j < run.n(); ++j) {
    Panel& panel = figure.panels.emplace_back();
    panel = {.title = run.joint(j),
             .x_label = "t [s]",
             .y_label = fmt::format("q - measured [{}]", run.units(j).q),
             .fit_x = true};
    Series band{
        .label = "90 % band", .colour = best->look.colour, .x = to_vector(t), .mark = Mark::kBand};
    band.low = to_vector(limits.low.col(j) - run.measured.q.col(j).head(t.size()));
    band.high = to_vector(limits.high.col(j) - run.measured.q.col(j).head(t.size()));
    panel.series.push_back(std::move(band));
    panel.series.push_back(curve("measured", kMeasuredColour, t, Eigen::VectorXd::Zero(t.size())));
  }
  const auto rollout = run.rollout(*best);
  if (!rollout) return figure;
  for (int j = 0; j < run.n(); ++j)
    figure.panels[static_cast<std::size_t>(j)].series.push_back(curve(
        *best, rollout->t, rollout->q.col(j) - run.measured.q.col(j).head(rollout->t.size())));
  return figure;
}

Figure error_time(const Run& run) {
  Figure figure{.name = "error_time", .columns = 1, .panel_height_cm = 6};
  figure.caption = fmt::format(
      "Absolute position error of the open loops on {}, mean over joints, against time.",
      run.trajectory);
  Panel panel{.x_label = "t [s]", .y_label = "mean |q error| [rad]", .log_y = true, .fit_x = true};
  for (const RunModel& model : run.models) {
    if (const auto rollout = run.rollout(model))
      panel.series.push_back(
          curve(model, rollout->t,
                evaluate::mean_absolute_error(rollout->q, run.measured.q).cwiseMax(kSmallest)));
  }
  // The first samples lie decades below: the axis begins after the initial rise.
  double least = 1;
  for (const Series& series : panel.series)
    for (std::size_t i = series.y.size() / 100; i < series.y.size(); ++i)
      least = std::min(least, series.y[i]);
  panel.y_range.low = std::pow(10, std::floor(std::log10(std::max(least, kSmallest))));
  if (!panel.series.empty()) figure.panels.push_back(std::move(panel));
  return figure;
}

Figure error_horizon(const Run& run) {
  Figure figure{.name = "error_horizon", .columns = 1, .width_cm = kColumnCm, .panel_height_cm = 6};
  Panel panel{.x_label = "horizon [s]", .y_label = "MSE(q) [rad²]", .log_x = true, .log_y = true};
  const std::vector<double>& horizons = run.evaluation.horizons_s;
  panel.x_range = {0.7 * horizons.front(), 1.4 * horizons.back()};
  for (const double horizon : horizons)
    panel.x_tics.emplace_back(horizon, fmt::format("{:.3g}", horizon));
  const std::vector<double>& floor = run.evaluation.floor;
  const bool has_floor =
      std::any_of(floor.begin(), floor.end(), [](double x) { return std::isfinite(x); });
  if (has_floor)
    panel.series.push_back({.label = "floor",
                            .colour = kTruthColour,
                            .x = horizons,
                            .y = floor,
                            .width = 3,
                            .mark = Mark::kLine});
  std::string over = "none";
  const std::vector<RunModel>& models = run.models;
  for (std::size_t m = 0; m < models.size(); ++m) {
    const RunModel& model = models[m];
    const evaluate::Summary* summary = run.summary(model.name);
    if (summary == nullptr) continue;
    // Bars side by side: a shift of 2 % per model on the log axis.
    const double shift =
        std::pow(1.02, static_cast<double>(m) - static_cast<double>(models.size() - 1) / 2);
    Series line{.label = model.label,
                .colour = model.look.colour,
                .y = summary->q_mse_geometric_mean,
                .width = 1.4,
                .dash = model.look.dash,
                .mark = Mark::kLinePoints,
                .marker = model.look.marker};
    for (const double horizon : horizons) line.x.push_back(horizon * shift);
    over = summary->interval_over;
    if (over != "none") {
      Series bars = line;
      bars.label.clear();
      bars.mark = Mark::kBars;
      bars.dash = 1;
      bars.width = 0.8;
      for (const evaluate::Interval& interval : summary->interval_90) {
        bars.low.push_back(interval.low);
        bars.high.push_back(interval.high);
      }
      panel.series.push_back(bars);
    }
    panel.series.push_back(line);
  }
  figure.caption =
      "Geometric mean of the open-loop MSE(q) over trajectories, start times and seeds, against "
      "the horizon." +
      (over == "none" ? std::string() : fmt::format(" Bars: 90 % interval over {}.", over)) +
      (has_floor ? " No model can be better than the floor." : "");
  figure.panels.push_back(std::move(panel));
  return figure;
}

Figure error_joint(const Run& run) {
  const std::vector<double>& horizons = run.evaluation.horizons_s;
  Figure figure{.name = "error_joint", .columns = 2, .panel_height_cm = 5};
  figure.caption =
      "Open-loop error of each joint: root of the geometric mean of its MSE over trajectories, "
      "start times and seeds; bars from the best to the worst of them.";
  std::vector<std::pair<double, std::string>> joints;
  for (int j = 0; j < run.n(); ++j) joints.emplace_back(j, run.joint(j));

  // One second, where friction dominates, and the longest horizon.
  std::vector<std::size_t> shown;
  for (std::size_t h = 0; h < horizons.size(); ++h)
    if (horizons[h] == 1 || h + 1 == horizons.size()) shown.push_back(h);
  for (const std::size_t h : shown) {
    Panel panel{.title = fmt::format("first {:.4g} s", horizons[h]),
                .y_label = "RMS(q) [rad]",
                .log_y = true,
                .x_range = {-0.6, run.n() - 0.4},
                .x_tics = joints};
    const std::vector<RunModel>& models = run.models;
    for (std::size_t m = 0; m < models.size(); ++m) {
      const RunModel& model = models[m];
      Series bars{.label = model.label,
                  .colour = model.look.colour,
                  .width = 1,
                  .mark = Mark::kBars,
                  .marker = model.look.marker};
      for (int j = 0; j < run.n(); ++j) {
        const auto errors = evaluate::joint_errors(run.evaluation, model.name,
                                                   static_cast<std::size_t>(j), h, kSmallest);
        if (!errors) continue;
        bars.x.push_back(
            j + 0.8 * ((static_cast<double>(m) + 0.5) / static_cast<double>(models.size()) - 0.5));
        bars.y.push_back(errors->typical);
        bars.low.push_back(errors->smallest);
        bars.high.push_back(errors->largest);
      }
      if (!bars.x.empty()) panel.series.push_back(std::move(bars));
    }
    if (!panel.series.empty()) figure.panels.push_back(std::move(panel));
  }
  return figure;
}

}  // namespace fricid::render
