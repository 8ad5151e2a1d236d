#include <fmt/format.h>
#include <algorithm>
#include <cmath>

#include "figure_parts.hpp"
#include "fricid/data/contact_file.hpp"
#include "fricid/data/signal_file.hpp"
#include "fricid/workflow/recordings.hpp"

namespace fricid::render {
namespace {

using evaluate::LoopScore;

/// A line in the look of what a loop feeds forward.
Series line_of(const Run& run, const LoopScore& loop) {
  const Look look = look_of_loop(run, loop.model);
  return {.label = loop.label, .colour = look.colour, .dash = look.dash, .marker = look.marker};
}

std::string words(const LoopScore& loop) {
  return fmt::format("{:.2g} rad/s, {:g} Hz", loop.peak_rad_s, loop.bandwidth_hz);
}

/// The joint that errs most at reversals when nothing is fed forward.
int worst_joint(const evaluate::CompensationFile& file) {
  const std::vector<double>& errors = file.loops.front().reversal_rad;
  return static_cast<int>(std::ranges::max_element(errors) - errors.begin());
}

}  // namespace

Figure compensation(const Run& run) {
  Figure figure{.name = "compensation", .columns = 2, .panel_height_cm = 5};
  if (!run.compensation) return figure;
  figure.caption =
      "Friction fed forward to the controller: RMS tracking error at reversals over joints against "
      "the gain of the fed forward torque, for every path (fastest speed) and bandwidth of the "
      "controller. Grey: nothing is fed forward.";
  for (const LoopScore& loop : run.compensation->loops) {
    const std::string title = words(loop);
    auto panel = std::ranges::find(figure.panels, title, &Panel::title);
    if (panel == figure.panels.end()) {
      figure.panels.push_back(
          {.title = title, .x_label = "gain", .y_label = "RMS error [mrad]", .log_y = true});
      panel = figure.panels.end() - 1;
    }
    auto series = std::ranges::find(panel->series, loop.label, &Series::label);
    if (series == panel->series.end()) {
      panel->series.push_back(line_of(run, loop));
      series = panel->series.end() - 1;
      series->mark = Mark::kLinePoints;
    }
    if (loop.diverged) continue;
    series->x.push_back(loop.gain);
    series->y.push_back(1e3 * evaluate::rms(loop.reversal_rad));
  }
  // nothing fed forward has no gain: a level over all of them
  for (Panel& panel : figure.panels) {
    std::vector<double> gains;
    for (const Series& series : panel.series)
      for (const double gain : series.x)
        if (gain > 0) gains.push_back(gain);
    if (gains.empty()) continue;
    const auto [low, high] = std::ranges::minmax(gains);
    for (Series& series : panel.series)
      if (series.x == std::vector<double>{0}) {
        series.x = {low, high};
        series.y.push_back(series.y.front());
        series.mark = Mark::kLine;
      }
  }
  return figure;
}

Figure compensation_time(const Run& run) {
  Figure figure{.name = "compensation_time", .columns = 1, .panel_height_cm = 4.6};
  if (!run.compensation || run.compensation->loops.empty()) return figure;
  const LoopScore& shown = run.compensation->loops.front();
  const int j = worst_joint(*run.compensation);
  Panel error{.x_label = "t [s]",
              .y_label = fmt::format("q - desired [{}]", run.units(j).milli_q),
              .fit_x = true},
      torque{.x_label = "t [s]",
             .y_label = fmt::format("friction [{}]", run.units(j).tau),
             .fit_x = true};
  double gain = 0;
  for (const LoopScore& loop : run.compensation->loops) {
    if (loop.path != shown.path || loop.controller != shown.controller) continue;
    if (gain == 0) gain = loop.gain;
    if (loop.gain != 0 && loop.gain != gain) continue;
    const auto signals = workflow::if_there(
        run.folder.loop(loop.model, loop.path, loop.controller),
        [&](const auto& file) { return data::load_signals<data::LoopSignals>(file, run.n()); });
    if (!signals) continue;
    const auto add = [&](Panel& panel, const Eigen::VectorXd& y) {
      Series series = line_of(run, loop);
      series.x = to_vector(signals->t);
      series.y = to_vector(y);
      panel.series.push_back(std::move(series));
    };
    add(error, 1e3 * (signals->q.col(j) - signals->q_desired.col(j)));
    if (loop.model != evaluate::kNoModel) add(torque, signals->tau_forward.col(j));
    if (loop.model == evaluate::kTruthModel)
      torque.series.insert(torque.series.begin(), {.label = "true friction",
                                                   .colour = kTruthColour,
                                                   .x = to_vector(signals->t),
                                                   .y = to_vector(signals->tau_f.col(j)),
                                                   .width = 3});
  }
  if (!error.series.empty()) figure.panels = {std::move(error), std::move(torque)};
  figure.caption = fmt::format(
      "{}, {}, gain {:g}: tracking error of each model, and what is fed forward. Grey: nothing is "
      "fed forward; below: the true friction of the arm that follows with the truth.",
      run.joint(j), words(shown), gain);
  return figure;
}

Figure contact(const Run& run) {
  Figure figure{.name = "contact"};
  if (!run.contact) return figure;
  const auto loop = workflow::if_there(run.folder.pushed_loop(), [&](const auto& file) {
    return data::load_signals<data::LoopSignals>(file, run.n());
  });
  if (!loop) return figure;
  figure.caption = fmt::format(
      "External torque under pushes of {:g} N by a momentum observer of {:g} Hz with the friction "
      "of each model. Grey: the true torque of the pushes.",
      run.contact->first_force(), run.contact->bandwidth_hz);
  for (int j = 0; j < run.n(); ++j)
    figure.panels.push_back(
        {.title = run.joint(j),
         .x_label = "t [s]",
         .y_label = fmt::format("external torque [{}]", run.units(j).tau),
         .series = {curve("applied", kTruthColour, loop->t, loop->tau_ext.col(j), 2.5)},
         .fit_x = true});
  for (const evaluate::ContactScore& score : run.contact->models) {
    if (score.method != evaluate::kObserver) continue;
    const auto signals = workflow::if_there(
        run.folder.external_torque(score.model),
        [&](const auto& file) { return data::load_signals<data::ContactSignals>(file, run.n()); });
    if (!signals) continue;
    const Look look = look_of_loop(run, score.model);
    for (int j = 0; j < run.n(); ++j) {
      Series series = curve(score.label, look.colour, signals->t, signals->tau_ext.col(j), 0.9);
      series.dash = look.dash;
      figure.panels[static_cast<std::size_t>(j)].series.push_back(std::move(series));
    }
  }
  return figure;
}

Figure contact_threshold(const Run& run) {
  Figure figure{
      .name = "contact_threshold", .columns = 1, .width_cm = kColumnCm, .panel_height_cm = 6};
  if (!run.contact) return figure;
  figure.caption = fmt::format(
      "Threshold of one false alarm per hour at every joint, from {:.2g} h without contact.",
      run.contact->hours);
  Panel panel{.y_label = "threshold [N m]", .log_y = true, .x_range = {-0.6, run.n() - 0.4}};
  for (int j = 0; j < run.n(); ++j) panel.x_tics.emplace_back(j, run.heading(j));
  for (const evaluate::ContactScore& score : run.contact->models) {
    const Look look = look_of_loop(run, score.model);
    Series series{.label = score.label,
                  .colour = look.colour,
                  .y = score.threshold_Nm,
                  .dash = score.method == evaluate::kObserver ? look.dash : 3,
                  .mark = Mark::kLinePoints,
                  .marker = look.marker};
    for (std::size_t j = 0; j < series.y.size(); ++j) series.x.push_back(static_cast<double>(j));
    panel.series.push_back(std::move(series));
  }
  figure.panels = {std::move(panel)};
  return figure;
}

}  // namespace fricid::render
