#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <map>
#include <set>

#include <fmt/format.h>

#include "figure_parts.hpp"
#include "fricid/base/names.hpp"
#include "fricid/base/unit_of_joint.hpp"
#include "fricid/data/artefact.hpp"
#include "fricid/signals/overview.hpp"
#include "fricid/sim/excitation_file.hpp"
#include "fricid/workflow/recordings.hpp"

namespace fricid::render {
namespace {

constexpr double kTwoSd = 2;
constexpr std::size_t kMostTiles = 14;  // in a row of a correlation matrix
constexpr double kRelated = 0.5,
                 kConfused = 0.9;  // |correlation| shown by a sign, and by a bold one

Series counted(const RunModel& model, std::vector<double> y, double first = 0) {
  Series series{.label = model.label,
                .colour = model.look.colour,
                .y = std::move(y),
                .dash = model.look.dash};
  for (std::size_t i = 0; i < series.y.size(); ++i)
    series.x.push_back(first + static_cast<double>(i));
  return series;
}

std::vector<double> per_iteration(const data::FittedEm& em, double data::FittedIteration::*value) {
  std::vector<double> values;
  for (const data::FittedIteration& iteration : em.iterations) values.push_back(iteration.*value);
  return values;
}

/// Whether a parameter of a law is plotted: not those of elements and weights, which are too many,
/// nor smoothing speeds, which are numerical.
bool is_shown(const friction::ParameterRef& parameter, const friction::RobotFriction& friction) {
  using enum friction::Role;
  if (parameter.joint == friction::kWholeRobot) return false;
  const auto& laws = friction.joints()[static_cast<std::size_t>(parameter.joint)].laws;
  const friction::ParameterInfo& info = parameter.info;
  return parameter.owner == laws[static_cast<std::size_t>(parameter.law)].law &&
         info.element == 0 && info.role != kSmoothingSpeed && info.role != kLoadSmoothing &&
         info.role != kSaturationSpeed;
}

/// A curve of more samples than a panel can show as the median of each bin, with a band from its
/// least to its largest value; a shorter one unchanged.
std::vector<Series> binned(const Series& curve) {
  constexpr std::size_t kBins = 200;
  const std::size_t size = curve.x.size() / kBins;
  if (size < 2) return {curve};
  Series band = curve, median = curve;
  band.label.clear();
  band.mark = Mark::kBand;
  for (Series* series : {&band, &median}) {
    series->x.clear();
    series->y.clear();
  }
  for (std::size_t begin = 0; begin + size <= curve.x.size(); begin += size) {
    std::vector<double> bin(curve.y.begin() + static_cast<std::ptrdiff_t>(begin),
                            curve.y.begin() + static_cast<std::ptrdiff_t>(begin + size));
    std::sort(bin.begin(), bin.end());
    const double middle = curve.x[begin + size / 2];
    band.x.push_back(middle);
    band.low.push_back(bin.front());
    band.high.push_back(bin.back());
    median.x.push_back(middle);
    median.y.push_back(bin[size / 2]);
  }
  return {std::move(band), std::move(median)};
}

}  // namespace

Figure training(const Run& run) {
  Figure figure{.name = "training", .columns = 3, .panel_height_cm = 4.6};
  figure.caption =
      "Training: the loss of each step, and the error of held-out rollouts that chose the model.";
  Panel loss{.x_label = "step [1000]", .y_label = "multi-step loss", .log_y = true},
      held_out{.x_label = "share of the training [%]",
               .y_label = "held-out MSE(q) [rad²]",
               .log_y = true};
  for (const RunModel& model : run.fitted()) {
    const auto fit = run.fit(model);
    if (!fit) continue;
    if (fit->multi_step) {
      const data::FittedTraining& report = *fit->multi_step;
      loss.series.push_back(counted(model, report.loss, 1));
      for (double& step : loss.series.back().x) step /= 1000;
      Series chosen = counted(model, report.held_out);
      chosen.x.assign(report.checked.begin(), report.checked.end());
      if (!chosen.x.empty())
        for (double& x : chosen.x) x *= 100 / std::max<double>(1, report.checked.back());
      chosen.mark = Mark::kLinePoints;
      chosen.marker = model.look.marker;
      held_out.series.push_back(std::move(chosen));
    }
    if (fit->em && !fit->em->iterations.empty()) {
      const data::FittedEm& report = *fit->em;
      std::vector<double> error{report.held_out_start};
      for (const data::FittedIteration& iteration : report.iterations)
        error.push_back(iteration.held_out);
      Series chosen = counted(model, error);
      for (double& x : chosen.x) x *= 100 / static_cast<double>(error.size() - 1);
      chosen.mark = Mark::kLinePoints;
      chosen.marker = model.look.marker;
      held_out.series.push_back(std::move(chosen));
    }
  }
  for (Panel* panel : {&loss, &held_out})
    if (!panel->series.empty()) figure.panels.push_back(std::move(*panel));
  return figure;
}

Figure em(const Run& run) {
  Figure figure{.name = "em", .columns = 3, .panel_height_cm = 4.6};
  figure.caption =
      "Expectation-maximisation, iteration by iteration: mean negative log transition density "
      "after "
      "the M-step, log-likelihood against the first iteration, noise of the velocity per sample "
      "(geometric mean over joints), normalised innovation squared per channel (1: the noise is as "
      "large as the model assumes), least share of distinct roots of the smoothed paths (0: the "
      "paths have one ancestor), and least median of the effective particles of backward sampling. "
      "A Kalman smoother has neither of the last two.";
  using Iteration = data::FittedIteration;
  const auto panel_of = [](std::string y_label, bool log_y = false) {
    return Panel{.x_label = "EM iteration", .y_label = std::move(y_label), .log_y = log_y};
  };
  Panel objective = panel_of("objective [nat]"),
        likelihood = panel_of("log-likelihood gain [1000 nat]"),
        noise = panel_of("sd of v [rad/s]", true), nis = panel_of("NIS per channel", true),
        roots = panel_of("distinct roots"), backward = panel_of("backward ESS", true);
  roots.y_range = {0, 1.05};
  for (const RunModel& model : run.fitted()) {
    const auto fit = run.fit(model);
    if (!fit || !fit->em || fit->em->iterations.empty()) continue;
    const auto values = [&](double Iteration::*value) { return per_iteration(*fit->em, value); };
    const auto add = [&](Panel& panel, std::vector<double> y) {
      panel.series.push_back(counted(model, std::move(y), 1));
    };
    add(objective, values(&Iteration::objective));
    std::vector<double> gain = values(&Iteration::log_likelihood);
    const double first = gain.front();
    for (double& value : gain) value = (value - first) / 1000;
    add(likelihood, std::move(gain));
    add(noise, values(&Iteration::velocity_sd));
    add(nis, values(&Iteration::nis));
    const std::vector<double> ess = values(&Iteration::least_backward_ess);
    const bool particles = std::ranges::any_of(ess, [](double x) { return x > 0; });
    if (const auto least = values(&Iteration::least_roots);
        particles || std::ranges::any_of(least, [](double share) { return share < 1; }))
      add(roots, least);
    if (particles) add(backward, ess);
  }
  for (Panel* panel : {&objective, &likelihood, &noise, &nis, &roots, &backward})
    if (!panel->series.empty()) figure.panels.push_back(std::move(*panel));
  return figure;
}

Figure filter_health(const Run& run) {
  Figure figure{
      .name = "filter_health", .columns = 1, .width_cm = kColumnCm, .panel_height_cm = 4.6};
  figure.caption =
      "Effective sample size of the online filter (of a long log the median and the range over "
      "two-hundredths of it).";
  Panel ess{.x_label = "t [s]", .y_label = "effective particles", .fit_x = true};
  for (const RunModel& model : run.fitted())
    if (const auto estimate = run.estimate(model))
      for (Series& series : binned(curve(model, estimate->t, estimate->ess)))
        ess.series.push_back(std::move(series));
  if (!ess.series.empty()) figure.panels.push_back(std::move(ess));
  return figure;
}

Figure parameters(const Run& run) {
  constexpr double kOnLowerEnd = 1.001;  // of the range: a part that the joint has not
  Figure figure{.name = "parameters"};
  figure.caption =
      "Friction parameters that several laws share, or of which the truth is known, joint by "
      "joint; bars: two standard errors. Grey rings: as injected, where the truth has the same "
      "law. Parameters of different laws differ in meaning, even under the same name. Values on "
      "the lower "
      "end of their range, of parts that a joint has not, may lie below the axis.";
  std::vector<std::pair<double, std::string>> joints;
  for (int j = 0; j < run.n(); ++j) joints.emplace_back(j, run.joint(j));

  std::map<std::string, std::vector<Series>> by_symbol;
  std::map<std::string, double> least_of;                              // above the lower end
  std::map<std::string, std::set<std::string, std::greater<>>> units;  // those that turn first
  std::vector<std::string> order;
  const std::vector<RunModel> models = run.fitted();
  for (std::size_t m = 0; m < models.size(); ++m) {
    const RunModel& model = models[m];
    const auto file = run.model_file(model);
    if (!file) continue;
    const auto fit = run.fit(model);
    std::map<std::string, Series> own;
    const auto& [friction, theta] = file->arm.friction;
    for (int i = 0; i < friction.parameter_count(); ++i) {
      const friction::ParameterRef& parameter = friction.parameters()[static_cast<std::size_t>(i)];
      if (!is_shown(parameter, friction)) continue;
      Series& series = own[parameter.symbol];
      if (parameter.info.has_unit() && parameter.joint >= 0 && parameter.joint < run.n()) {
        const bool slides = run.slides[static_cast<std::size_t>(parameter.joint)];
        units[parameter.symbol].insert(unit_of_joint(parameter.info.unit, slides));
      }
      const double value = theta[static_cast<std::size_t>(i)];
      const data::FittedParameter* fitted =
          fit ? data::fitted_parameter(*fit, friction, i) : nullptr;
      const double error = fitted == nullptr ? kNaN : fitted->standard_error;
      const double half = std::isfinite(error) ? kTwoSd * error : 0;
      series.x.push_back(
          parameter.joint +
          0.7 * ((static_cast<double>(m) + 0.5) / static_cast<double>(models.size()) - 0.5));
      series.y.push_back(value);
      if (value > kOnLowerEnd * parameter.info.lower) {
        const auto least = least_of.try_emplace(parameter.symbol, value).first;
        least->second = std::min(least->second, value);
      }
      series.low.push_back(value - half);
      series.high.push_back(value + half);
    }
    for (auto& [symbol, series] : own) {
      series.label = model.label;
      series.colour = model.look.colour;
      series.marker = model.look.marker;
      series.mark = Mark::kBars;
      series.width = 0.9;
      if (by_symbol[symbol].empty()) order.push_back(symbol);
      by_symbol[symbol].push_back(std::move(series));
    }
  }
  for (const std::string& symbol : order) {
    Series truth{
        .label = "truth", .colour = "#777777", .width = 1.4, .mark = Mark::kPoints, .marker = 6};
    if (run.truth) {
      const friction::Friction& injected = run.truth->friction;
      for (int j = 0; j < run.n(); ++j)
        if (const int i = friction::find_parameter(injected.model, j, "", symbol); i >= 0) {
          truth.x.push_back(j);
          truth.y.push_back(injected.theta[static_cast<std::size_t>(i)]);
        }
    }
    std::vector<Series> series = by_symbol[symbol];
    if (truth.x.empty() && series.size() < 2) continue;
    Panel panel{.title = symbol,
                .y_label = units[symbol].empty()
                               ? std::string()
                               : fmt::format("[{}]", fmt::join(units[symbol], ", ")),
                .series = std::move(series),
                .x_range = {-0.6, run.n() - 0.4},
                .x_tics = {}};
    for (int j = 0; j < run.n(); ++j) panel.x_tics.emplace_back(j, fmt::format("{}", j + 1));
    panel.x_label = "joint";
    if (!truth.x.empty()) panel.series.push_back(truth);
    double least = INFINITY, most = 0;
    for (const Series& one : panel.series)
      for (const double value : one.y) {
        least = std::min(least, value);
        most = std::max(most, value);
      }
    panel.log_y = least > 0 && most > 100 * least;
    if (const auto above = least_of.find(symbol);
        panel.log_y && above != least_of.end() && above->second > least)
      panel.y_range = {above->second / 2, 2 * most};
    figure.panels.push_back(std::move(panel));
  }
  return figure;
}

/// A plus or a minus in the middle of a tile, as strokes of a line.
void add_sign(double x, double y, double value, Series& strokes) {
  constexpr double kArm = 0.16;
  const auto add = [&](double dx, double dy) {
    strokes.x.push_back(x - dx / 2);
    strokes.y.push_back(y - dy / 2);
    strokes.low.push_back(dx);
    strokes.high.push_back(dy);
  };
  add(2 * kArm, 0);
  if (value > 0) add(0, 2 * kArm);
}

/// Parameters of a correlation matrix that are known, at most `kMostTiles`: those that are related
/// most to another, in their order.
std::vector<Eigen::Index> most_related(const Eigen::MatrixXd& correlation) {
  std::vector<Eigen::Index> known;
  for (Eigen::Index i = 0; i < correlation.rows(); ++i)
    if (std::isfinite(correlation(i, i))) known.push_back(i);
  if (known.size() <= kMostTiles) return known;
  Eigen::VectorXd most = Eigen::VectorXd::Zero(correlation.rows());
  for (const Eigen::Index i : known)
    for (const Eigen::Index k : known)
      if (k != i) most[i] = std::max(most[i], std::abs(correlation(i, k)));
  std::ranges::stable_sort(known, std::greater(), [&](Eigen::Index i) { return most[i]; });
  known.resize(kMostTiles);
  std::ranges::sort(known);
  return known;
}

Figure correlation(const Run& run, const RunModel& model) {
  Figure figure{.name = file_stem("correlation_" + model.name), .left_cm = 2.1};
  figure.caption = fmt::format(
      "{}: correlation of the errors of its fitted parameters, joint by joint: white 0, vermilion "
      "1, blue -1; with its sign from 0.5 on, in bold from 0.9 on: the data determine a "
      "combination of the two better than each.",
      model.label);
  const auto fit = run.fit(model);
  if (!fit) return figure;
  bool some_left_out = false;
  for (std::size_t j = 0; j < fit->joints.size(); ++j) {
    const data::FittedJoint& joint = fit->joints[j];
    if (joint.correlation.size() == 0) continue;
    Panel panel{.title = run.joint(static_cast<int>(j))};
    Series tiles{.mark = Mark::kTiles}, signs{.width = 0.7, .mark = Mark::kStrokes},
        bold{.width = 1.6, .mark = Mark::kStrokes};
    const std::vector<Eigen::Index> known = most_related(joint.correlation);
    some_left_out |= joint.correlation.diagonal().array().isFinite().count() > std::ssize(known);
    for (std::size_t a = 0; a < known.size(); ++a) {
      const std::string& symbol = joint.parameters[static_cast<std::size_t>(known[a])].symbol;
      panel.x_tics.emplace_back(a, symbol);
      panel.y_tics.emplace_back(a, symbol);
      for (std::size_t b = 0; b < known.size(); ++b) {
        const double value = joint.correlation(known[a], known[b]);
        if (!std::isfinite(value)) continue;
        const auto x = static_cast<double>(b), y = static_cast<double>(a);
        tiles.x.push_back(x);
        tiles.y.push_back(y);
        tiles.low.push_back(value);
        if (a != b && std::abs(value) >= kRelated)
          add_sign(x, y, value, std::abs(value) < kConfused ? signs : bold);
      }
    }
    if (known.size() < 2) continue;
    const double most = static_cast<double>(known.size()) - 0.5;
    panel.x_range = {-0.5, most};
    panel.y_range = {most, -0.5};
    panel.series = {std::move(tiles), std::move(signs), std::move(bold)};
    figure.panels.push_back(std::move(panel));
  }
  if (some_left_out)
    figure.caption += fmt::format(
        " Of each joint the {} parameters that are related most to another.", kMostTiles);
  return figure;
}

Figure excitation(const Run& run) {
  Figure figure{.name = "excitation"};
  const std::string recording = workflow::RunFolder::training(0);
  const auto set = workflow::if_there(run.folder.recording(recording), data::load_dataset);
  if (!set || run.fitted().empty()) return figure;
  const auto model = run.model_file(run.fitted().front());
  figure.caption = fmt::format(
      "Excitation of {}: velocity against position, with the robot's limits where they are stated "
      "(dashed).",
      recording);
  for (int j = 0; j < set->n(); ++j) {
    const Eigen::VectorXd v = signals::slope(set->q.col(j), set->t);
    Panel panel{.title = set->joint_names[static_cast<std::size_t>(j)],
                .x_label = fmt::format("q [{}]", run.units(j).q),
                .y_label = fmt::format("v [{}]", run.units(j).v)};
    panel.series.push_back(curve("", "#0072B2", set->q.col(j), v, 0.8));
    if (model && j < model->arm.robot.n()) {
      const dynamics::Joint& joint = model->arm.robot.joints[static_cast<std::size_t>(j)];
      const double lower = joint.lower, upper = joint.upper, speed = joint.velocity;
      panel.series.push_back({.colour = "#777777",
                              .x = {lower, upper, upper, lower, lower},
                              .y = {speed, speed, -speed, -speed, speed},
                              .width = 0.9,
                              .dash = 2});
    }
    figure.panels.push_back(std::move(panel));
  }
  return figure;
}

Figure margins(const Run& run) {
  Figure figure{.name = "margins", .columns = 1, .width_cm = kColumnCm, .panel_height_cm = 5};
  const auto file = workflow::if_there(run.folder.excitation(), data::load<sim::ExcitationFile>);
  if (!file || file->trajectories.empty()) return figure;
  figure.caption =
      "Share of each allowed limit that the excitation uses, the most of all trajectories. At "
      "100 % it touches the limit that the scene allows.";
  struct Quantity {
    double sim::JointMargins::*margin;
    const char *label, *colour;
    int marker;
  };
  constexpr std::array kQuantities{
      Quantity{&sim::JointMargins::velocity, "velocity", "#0072B2", 7},
      Quantity{&sim::JointMargins::acceleration, "acceleration", "#E69F00", 9},
      Quantity{&sim::JointMargins::jerk, "jerk", "#009E73", 5},
      Quantity{&sim::JointMargins::torque, "torque", "#D55E00", 13}};
  Panel panel{
      .x_label = "share of the limit [%]", .x_range = {0, 105}, .y_range = {run.n() - 0.5, -0.5}};
  for (int j = 0; j < run.n(); ++j) panel.y_tics.emplace_back(j, run.joint(j));
  for (const Quantity& quantity : kQuantities) {
    Series series{.label = quantity.label,
                  .colour = quantity.colour,
                  .mark = Mark::kPoints,
                  .marker = quantity.marker};
    for (int j = 0; j < run.n(); ++j) {
      const double least = sim::least_margin(file->trajectories, run.joint(j), quantity.margin);
      if (!std::isfinite(least)) continue;
      series.x.push_back(100 * (1 - least));
      series.y.push_back(j);
    }
    panel.series.push_back(std::move(series));
  }
  panel.series.push_back(
      {.colour = "#777777", .x = {100, 100}, .y = {-0.5, run.n() - 0.5}, .dash = 2});
  figure.panels.push_back(std::move(panel));
  return figure;
}

}  // namespace fricid::render
