// Motor torque along the measured motion, and the residuals of the models.
#include <fmt/format.h>

#include "figure_parts.hpp"
#include "fricid/base/names.hpp"
#include "fricid/signals/block_means.hpp"
#include "fricid/signals/spectrum.hpp"

namespace fricid::render {
namespace {

constexpr int kSegment = 1024;  // samples of one periodogram

}  // namespace

Figure torque(const Run& run, const RunModel& model) {
  Figure figure{.name = file_stem("torque_" + model.name)};
  figure.caption =
      fmt::format("Motor torque on {} predicted by {} along the measured motion, and the residual.",
                  run.trajectory, model.label);
  const auto signals = run.prediction(model);
  if (!signals) return figure;
  const Eigen::VectorXd& t = signals->t;
  const RowMatrix &measured = signals->tau, &predicted = signals->tau_predicted;
  for (int j = 0; j < run.n(); ++j) {
    Panel panel{.title = run.joint(j),
                .x_label = "t [s]",
                .y_label = fmt::format("tau [{}]", run.units(j).tau),
                .fit_x = true};
    panel.series = {
        curve("measured - predicted", kTruthColour, t, measured.col(j) - predicted.col(j), 0.8),
        curve("measured", kMeasuredColour, t, measured.col(j), 0.8),
        curve(model, t, predicted.col(j))};
    panel.series.back().dash = 1;
    figure.panels.push_back(std::move(panel));
  }
  return figure;
}

Figure residual_spectrum(const Run& run) {
  Figure figure{.name = "residual_spectrum"};
  figure.caption = fmt::format(
      "Spectrum of each model's torque residual along the measured motion of {} (Welch, Hann "
      "windows of {} samples). Flat: noise; a rise towards low frequencies: friction or inertia "
      "that the model lacks. Black: the measured torque.",
      run.trajectory, kSegment);
  for (int j = 0; j < run.n(); ++j)
    figure.panels.push_back(
        {.title = run.joint(j),
         .x_label = "frequency [Hz]",
         .y_label = fmt::format("density [{}/Hz]", run.units(j).tau_squared),
         .log_x = true,
         .log_y = true,
         .x_range = {run.measured.rate_hz / kSegment, run.measured.rate_hz / 2}});
  const auto add = [&](int j, Series look, const Eigen::VectorXd& signal) {
    const signals::Spectrum spectrum =
        signals::smoothed_by_octaves(signals::welch(signal, run.measured.rate_hz, kSegment));
    look.x = to_vector(spectrum.frequency_hz);
    look.y = to_vector(spectrum.density);
    look.width = 0.9;
    figure.panels[static_cast<std::size_t>(j)].series.push_back(std::move(look));
  };
  bool any = false;
  for (const RunModel& model : run.fitted()) {
    const auto prediction = run.prediction(model);
    if (!prediction) continue;
    for (int j = 0; j < run.n(); ++j) {
      if (!any)
        add(j, {.label = "measured torque", .colour = kMeasuredColour}, prediction->tau.col(j));
      add(j, {.label = model.label, .colour = model.look.colour, .dash = model.look.dash},
          prediction->tau.col(j) - prediction->tau_predicted.col(j));
    }
    any = true;
  }
  if (!any) figure.panels.clear();
  return figure;
}

Figure torque_drift(const Run& run) {
  Figure figure{.name = "torque_drift"};
  figure.caption = fmt::format(
      "Torque residual of each model along the measured motion of {}, mean over twentieths of the "
      "recording: a level is a missing offset, a slope is drift (warming up).",
      run.trajectory);
  for (int j = 0; j < run.n(); ++j)
    figure.panels.push_back({.title = run.joint(j),
                             .x_label = "t [s]",
                             .y_label = fmt::format("mean residual [{}]", run.units(j).tau),
                             .fit_x = true});
  bool any = false;
  for (const RunModel& model : run.fitted()) {
    const auto prediction = run.prediction(model);
    if (!prediction) continue;
    any = true;
    const RowMatrix left = prediction->tau - prediction->tau_predicted;
    if (left.rows() < evaluate::kDriftBlocks) continue;
    const Eigen::VectorXd t = signals::block_means(prediction->t, evaluate::kDriftBlocks);
    for (int j = 0; j < run.n(); ++j) {
      Series series = curve(model, t, signals::block_means(left.col(j), evaluate::kDriftBlocks));
      series.mark = Mark::kLinePoints;
      series.marker = model.look.marker;
      series.width = 0.9;
      figure.panels[static_cast<std::size_t>(j)].series.push_back(std::move(series));
    }
  }
  if (!any) figure.panels.clear();
  return figure;
}

}  // namespace fricid::render
