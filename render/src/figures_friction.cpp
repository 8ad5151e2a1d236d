#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

#include <fmt/format.h>

#include "figure_parts.hpp"
#include "fricid/base/names.hpp"
#include "fricid/evaluate/characteristics.hpp"

namespace fricid::render {
namespace {

constexpr std::string_view kReferenceLaw = "coulomb_viscous";
constexpr double kWindow = 5;        // [s] shown of time series
constexpr double kNormal90 = 1.645;  // half width of a 90 % band in standard deviations

/// The part of a curve between two times, counted from `zero`.
Series cut(Series series, double begin, double end, double zero = 0, double scale = 1) {
  Series part = series;
  part.x.clear();
  part.y.clear();
  for (std::size_t i = 0; i < series.x.size(); ++i)
    if (series.x[i] >= begin && series.x[i] <= end) {
      part.x.push_back((series.x[i] - zero) * scale);
      part.y.push_back(series.y[i]);
    }
  return part;
}

/// The first kWindow seconds of a curve, whose times need not begin at zero.
Series beginning(const Series& series) {
  const double begin = series.x.empty() ? 0 : series.x.front();
  return cut(series, begin, begin + kWindow);
}

/// States of the first joint, or the first ones of a law of the whole robot.
Eigen::Index shown_states(const friction::RobotFriction& model) {
  constexpr int kMost = 4;
  const int of_joint = model.state_begin(1);
  return of_joint > 0 ? of_joint : std::min(kMost, model.state_size());
}

}  // namespace

Figure friction_loop(const Run& run, int joint) {
  const std::string& name = run.joint(joint);
  Figure figure{.name = file_stem("friction_" + name)};
  const std::vector<RunModel> models = run.fitted();
  const auto reference = std::ranges::find(models, kReferenceLaw, &RunModel::law);
  const auto of_reference =
      reference == models.end() || models.size() == 1 ? std::nullopt : run.prediction(*reference);
  figure.caption = fmt::format(
      "Friction characteristic of {} on {}: torque of each model driven by the measured motion, "
      "against velocity.{}{}",
      name, run.trajectory, run.truth ? " Grey: the injected friction." : "",
      of_reference ? fmt::format(" Thin black: {}.", reference->label) : "");
  for (const RunModel& model : models) {
    const auto predicted = run.prediction(model);
    if (!predicted || (of_reference && model.name == reference->name)) continue;
    Panel panel{.title = fmt::format("{}, {}", name, model.label),
                .x_label = fmt::format("v [{}]", run.units(joint).v),
                .y_label = fmt::format("friction [{}]", run.units(joint).tau)};
    if (run.truth)
      panel.series.push_back(curve("truth", kTruthColour, run.truth->trace.v.col(joint),
                                   run.truth->trace.tau_f.col(joint), 2.6));
    panel.series.push_back(curve(model, predicted->v.col(joint), predicted->tau_f.col(joint)));
    panel.series.back().dash = 1;
    panel.series.back().width = 0.9;
    if (of_reference)
      panel.series.push_back(curve(reference->label, kMeasuredColour, of_reference->v.col(joint),
                                   of_reference->tau_f.col(joint), 0.5));
    figure.panels.push_back(std::move(panel));
  }
  return figure;
}

Figure presliding(const Run& run) {
  Figure figure{.name = "presliding"};
  std::vector<std::pair<RunModel, friction::Friction>> shown;
  for (const RunModel& model : run.fitted())
    if (auto file = run.model_file(model)) shown.emplace_back(model, file->arm.friction);
  if (shown.empty()) return figure;

  // The loops are scaled by the truth, or else by the model with the longest presliding.
  std::vector<friction::Friction> of_scale;
  if (run.truth)
    of_scale.push_back(run.truth->friction);
  else
    for (const auto& [model, friction] : shown) of_scale.push_back(friction);
  const evaluate::PreslidingMotion motion = evaluate::presliding_motion_through(of_scale);
  figure.caption =
      "Presliding: the law of every model moved slowly from rest around an outer and an inner "
      "loop, "
      "without load. Hysteresis with memory closes both loops; a law without memory that is smooth "
      "in velocity stays near zero.";
  if (run.truth) figure.caption += " Grey: the injected friction.";
  const Eigen::MatrixXd milli = 1e3 * motion.q;
  for (int j = 0; j < run.n(); ++j) {
    Panel panel{.title = run.joint(j),
                .x_label = fmt::format("displacement [{}]", run.units(j).milli_q),
                .y_label = fmt::format("friction [{}]", run.units(j).tau)};
    figure.panels.push_back(std::move(panel));
  }
  const auto add = [&](const friction::Friction& friction, Series look) {
    const RowMatrix tau_f = evaluate::presliding_loop(friction, motion);
    for (int j = 0; j < run.n(); ++j) {
      look.x = to_vector(milli.col(j));
      look.y = to_vector(tau_f.col(j));
      figure.panels[static_cast<std::size_t>(j)].series.push_back(look);
    }
  };
  if (run.truth) add(run.truth->friction, {.label = "truth", .colour = kTruthColour, .width = 3});
  for (const auto& [model, friction] : shown)
    add(friction, {.label = model.label, .colour = model.look.colour, .dash = model.look.dash});
  return figure;
}

Figure reversal(const Run& run) {
  Figure figure{.name = "reversal"};
  figure.caption = fmt::format(
      "The slowest reversal of each joint on {}, friction torque against time: models driven by "
      "the measured motion.{}",
      run.trajectory, run.truth ? " Grey: the injected friction." : "");
  std::vector<std::pair<RunModel, evaluate::PredictionSignals>> shown;
  for (const RunModel& model : run.fitted())
    if (auto predicted = run.prediction(model)) shown.emplace_back(model, std::move(*predicted));
  if (shown.empty()) return figure;
  for (int j = 0; j < run.n(); ++j) {
    const evaluate::PredictionSignals& first = shown[0].second;
    const Eigen::Index k = evaluate::slowest_reversal(first.v.col(j), first.t[1] - first.t[0]);
    if (k < 0) continue;
    const double zero = first.t[k];
    Panel panel{.title = fmt::format("{}, t = {:.2f} s", run.joint(j), zero),
                .x_label = "time from the reversal [ms]",
                .y_label = fmt::format("friction [{}]", run.units(j).tau),
                .fit_x = true};
    const auto add = [&](const Series& series) {
      panel.series.push_back(cut(series, zero - evaluate::kAroundReversal,
                                 zero + evaluate::kAroundReversal, zero, 1e3));
    };
    if (run.truth)
      add(curve("truth", kTruthColour, run.truth->trace.t, run.truth->trace.tau_f.col(j), 3));
    for (const auto& [model, predicted] : shown)
      add(curve(model, predicted.t, predicted.tau_f.col(j)));
    figure.panels.push_back(std::move(panel));
  }
  return figure;
}

Figure friction_time(const Run& run) {
  Figure figure{.name = "friction_time"};
  bool has_band = false;
  for (int j = 0; j < run.n(); ++j) {
    Panel panel{.title = run.joint(j),
                .x_label = "t [s]",
                .y_label = fmt::format("friction [{}]", run.units(j).tau),
                .fit_x = true};
    for (const RunModel& model : run.fitted()) {
      const auto estimate = run.estimate(model);
      if (!estimate) continue;
      const Eigen::VectorXd mean = estimate->tau_f.col(j), sd = estimate->tau_f_sd.col(j);
      const Eigen::VectorXd& t = estimate->t;
      Series band{.colour = model.look.colour, .mark = Mark::kBand};
      for (Eigen::Index k = 0; k < t.size(); ++k)
        if (t[k] - t[0] <= kWindow) {
          band.x.push_back(t[k]);
          band.low.push_back(mean[k] - kNormal90 * sd[k]);
          band.high.push_back(mean[k] + kNormal90 * sd[k]);
        }
      panel.series.push_back(band);
      has_band = true;
    }
    if (run.truth)
      panel.series.push_back(beginning(
          curve("truth", kTruthColour, run.truth->trace.t, run.truth->trace.tau_f.col(j), 2.6)));
    for (const RunModel& model : run.fitted())
      if (const auto predicted = run.prediction(model))
        panel.series.push_back(beginning(curve(model, predicted->t, predicted->tau_f.col(j))));
    if (panel.series.size() > (run.truth ? 1U : 0U)) figure.panels.push_back(std::move(panel));
  }
  figure.caption = fmt::format(
      "Friction torque in the first {:.0f} s of {}: models driven by the measured motion.{}{}",
      kWindow, run.trajectory, run.truth ? " Grey: the injected friction." : "",
      has_band ? " Bands: 90 % intervals of the online filter." : "");
  return figure;
}

Figure friction_error(const Run& run) {
  Figure figure{.name = "friction_error"};
  if (!run.truth) return figure;
  figure.caption = fmt::format(
      "Error of the friction torque in the first {:.0f} s of {}: models driven by the measured "
      "motion against the injected friction. Hidden states start at zero, which causes the first "
      "errors.",
      kWindow, run.trajectory);
  for (int j = 0; j < run.n(); ++j) {
    Panel panel{.title = run.joint(j),
                .x_label = "t [s]",
                .y_label = fmt::format("error [{}]", run.units(j).tau),
                .fit_x = true};
    for (const RunModel& model : run.fitted()) {
      const auto predicted = run.prediction(model);
      if (!predicted || predicted->t.size() != run.truth->trace.t.size()) continue;
      panel.series.push_back(beginning(
          curve(model, predicted->t, predicted->tau_f.col(j) - run.truth->trace.tau_f.col(j))));
    }
    if (!panel.series.empty()) figure.panels.push_back(std::move(panel));
  }
  return figure;
}

/// Unit of the states of the first joint's laws; empty where units mix.
std::string unit_of_states(const friction::RobotFriction& model) {
  std::set<std::string_view> units;
  const auto add = [&](std::span<const friction::LawInfo> table, std::string_view name) {
    units.insert(std::ranges::find(table, name, &friction::LawInfo::name)->state_unit);
  };
  for (const friction::LawSpec& law : model.joints().front().laws) {
    add(friction::law_table(), law.law);
    for (const friction::ModifierSpec& modifier : law.modifiers)
      add(friction::modifier_table(), modifier.name);
  }
  if (model.has_whole()) add(friction::robot_law_table(), model.whole().law);
  units.erase("");
  return units.size() == 1 ? std::string(*units.begin()) : "";
}

Figure latent(const Run& run) {
  Figure figure{.name = "latent"};
  figure.caption = fmt::format(
      "Hidden states of {} in the first {:.0f} s of {}, driven by the measured motion, in the "
      "unit of the law of each model.",
      run.joint(0), kWindow, run.trajectory);
  const auto add = [&](const std::string& title, const std::string& colour, const std::string& unit,
                       const Eigen::VectorXd& t, const RowMatrix& z) {
    Panel panel{.title = title,
                .x_label = "t [s]",
                .y_label = unit.empty() ? "z" : fmt::format("z [{}]", unit),
                .fit_x = true};
    for (Eigen::Index i = 0; i < z.cols(); ++i) {
      Series state = beginning(curve("", colour, t, z.col(i), 0.9));
      state.dash = 1 + static_cast<int>(i % 4);
      panel.series.push_back(std::move(state));
    }
    if (!panel.series.empty()) figure.panels.push_back(std::move(panel));
  };
  if (run.truth) {
    const auto& model = run.truth->friction.model;
    const sim::Trace& trace = run.truth->trace;
    add("truth", "#555555", unit_of_states(model), trace.t,
        trace.z.leftCols(std::min<Eigen::Index>(model.state_begin(1), trace.z.cols())));
  }
  for (const RunModel& model : run.fitted()) {
    const auto predicted = run.prediction(model);
    const auto file = run.model_file(model);
    if (!predicted || !file || file->arm.friction.model.state_size() == 0) continue;
    const auto& friction = file->arm.friction;
    add(model.label, model.look.colour, unit_of_states(friction.model), predicted->t,
        evaluate::driven_states(file->arm, *predicted).leftCols(shown_states(friction.model)));
  }
  return figure;
}

}  // namespace fricid::render
