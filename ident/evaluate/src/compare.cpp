#include "fricid/evaluate/compare.hpp"
#include "fricid/evaluate/averages.hpp"

#include <algorithm>
#include <cmath>
#include <map>

#include <fmt/format.h>

#include "fricid/base/error.hpp"
#include "fricid/base/names.hpp"
#include "fricid/evaluate/headroom.hpp"
#include "markdown.hpp"

namespace fricid::evaluate {
namespace {

const Summary* summary_of(const ComparedRun& run, const std::string& name) {
  const auto& summary = run.evaluation.summary;
  const auto found = std::ranges::find(summary, name, &Summary::name);
  return found == summary.end() ? nullptr : &*found;
}

ComparedModel compare_model(const std::string& name, std::span<const ComparedRun> runs,
                            std::size_t horizons, const std::string& against) {
  ComparedModel model;
  model.name = name;
  std::vector<double> seconds_spent, friction, friction_rollout;
  std::vector<std::vector<double>> errors(horizons), ratios(horizons), to_named(horizons),
      inside(horizons);
  for (const ComparedRun& run : runs) {
    const Summary* summary = summary_of(run, name);
    if (summary == nullptr) continue;
    model.label = summary->label;
    model.is_oracle = summary->is_oracle;
    model.is_conventional = summary->is_conventional;
    model.parameters = summary->parameters;
    model.diverged += summary->diverged;
    model.rollouts += summary->rollouts;
    model.runs += 1;
    seconds_spent.push_back(fit_seconds(*summary, run.fit_seconds));
    friction.push_back(summary->friction);
    friction_rollout.push_back(summary->friction_rollout);
    if (summary->intervals) {
      if (!model.intervals) model.intervals.emplace();
      model.intervals->add(*summary->intervals);
    }
    const std::vector<double>& q_mse = summary->q_mse_geometric_mean;
    const Summary* named = summary_of(run, against);
    for (std::size_t h = 0; h < horizons; ++h) {
      errors[h].push_back(q_mse[h]);
      ratios[h].push_back(q_mse[h] / run.evaluation.best_conventional[h]);
      if (named != nullptr) to_named[h].push_back(q_mse[h] / named->q_mse_geometric_mean[h]);
      if (!summary->band_coverage.empty()) inside[h].push_back(summary->band_coverage[h]);
    }
  }
  model.fit_seconds = mean(seconds_spent);
  model.friction = mean(friction);
  model.friction_rollout = mean(friction_rollout);
  for (std::size_t h = 0; h < horizons; ++h) {
    model.q_mse.push_back(geometric_mean(errors[h]));
    model.interval_90.push_back(interval_90(errors[h]));
    model.against_convention.push_back(geometric_mean(ratios[h]));
    model.against_convention_90.push_back(interval_90(ratios[h]));
    model.against_named.push_back(geometric_mean(to_named[h]));
    model.against_named_90.push_back(interval_90(to_named[h]));
    if (!inside[h].empty()) model.band_coverage.push_back(mean(inside[h]));
  }
  return model;
}

/// Geometric mean over the runs of what `value` says of one.
template <class Value>
double mean_over(std::span<const ComparedRun> runs, const Value& value) {
  std::vector<double> values;
  for (const ComparedRun& run : runs) values.push_back(value(run.evaluation));
  return geometric_mean(values);
}

ComparedScene compare_scene(const std::string& name, std::span<const ComparedRun> runs,
                            const std::string& against) {
  ComparedScene scene;
  scene.scene = name;
  scene.runs = static_cast<int>(runs.size());
  scene.horizons_s = runs.front().evaluation.horizons_s;
  std::vector<std::string> models;
  for (const ComparedRun& run : runs) {
    if (run.evaluation.horizons_s != scene.horizons_s)
      throw UserError(
          "{}: horizons differ from those of {}; allowed: runs of {} with the same ones", run.place,
          runs.front().place, name);
    for (const Summary& summary : run.evaluation.summary)
      if (std::ranges::find(models, summary.name) == models.end()) models.push_back(summary.name);
  }
  const std::size_t horizons = scene.horizons_s.size();
  if (std::ranges::count(models, against) > 0) scene.against = against;
  for (const std::string& model : models)
    scene.models.push_back(compare_model(model, runs, horizons, scene.against));

  for (std::size_t h = 0; h < horizons; ++h) {
    const Headroom headroom{
        mean_over(runs, [&](const Evaluation& e) { return e.best_conventional[h]; }),
        mean_over(runs, [&](const Evaluation& e) {
          return std::isnan(e.oracle[h]) ? e.floor[h] : e.oracle[h];
        })};
    scene.headroom.push_back(headroom.ratio());
    for (ComparedModel& model : scene.models)
      model.headroom_closed.push_back(headroom.closed(model.q_mse[h]));
  }
  return scene;
}

Markdown markdown(const ComparedScene& scene) {
  std::vector<Cells> errors{horizon_titles(Markdown::of("model"), scene.horizons_s)},
      ratios{horizon_titles(Markdown::of("against convention"), scene.horizons_s)},
      to_named{
          horizon_titles(Markdown::of("against {}", escaped(scene.against)), scene.horizons_s)},
      closed{horizon_titles(Markdown::of("headroom closed"), scene.horizons_s)},
      inside{horizon_titles(Markdown::of("% inside the 90 % bands"), scene.horizons_s)};
  for (const Markdown& title :
       {Markdown::of("friction %"), Markdown::of("along the rollout %"), Markdown::of("diverged"),
        Markdown::of("parameters"), Markdown::of("fit s"), Markdown::of("runs")})
    errors[0].push_back(title);
  const auto with_interval = [](double value, const Interval& interval) {
    return std::isnan(interval.low) ? digits(value)
                                    : Markdown::of("{} ({})", digits(value), range(interval));
  };
  for (const ComparedModel& model : scene.models) {
    Cells& error = errors.emplace_back(Cells{escaped(model.label)});
    Cells& ratio = ratios.emplace_back(Cells{escaped(model.label)});
    Cells& of_named = to_named.emplace_back(Cells{escaped(model.label)});
    for (std::size_t h = 0; h < scene.horizons_s.size(); ++h) {
      error.push_back(with_interval(model.q_mse[h], model.interval_90[h]));
      ratio.push_back(with_interval(model.against_convention[h], model.against_convention_90[h]));
      of_named.push_back(with_interval(model.against_named[h], model.against_named_90[h]));
    }
    error.push_back(percent(model.friction));
    error.push_back(percent(model.friction_rollout));
    error.push_back(Markdown::of("{}/{}", model.diverged, model.rollouts));
    error.push_back(model.is_oracle ? Markdown::of("–") : Markdown::of("{}", model.parameters));
    error.push_back(model.is_oracle ? Markdown::of("–") : digits(model.fit_seconds));
    error.push_back(Markdown::of("{}", model.runs));
    append(closed.emplace_back(Cells{escaped(model.label)}), model.headroom_closed, fixed);
    if (!model.band_coverage.empty())
      append(inside.emplace_back(Cells{escaped(model.label)}), model.band_coverage, percent);
  }
  const Markdown parameters = parameter_table(scene.models);
  Cells& headroom = errors.emplace_back(Cells{Markdown::of("*headroom*")});
  append(headroom, scene.headroom, digits);
  headroom.resize(errors[0].size());
  return Markdown::of(
      "## {}: {} run{}\n\n{}\n{}\n{}{}{}{}", escaped(scene.scene), scene.runs,
      scene.runs == 1 ? Markdown() : Markdown::of("s"), markdown_table(errors),
      markdown_table(ratios),
      scene.against.empty() ? Markdown() : Markdown::of("{}\n", markdown_table(to_named)),
      markdown_table(closed),
      inside.size() == 1 ? Markdown() : Markdown::of("\n{}", markdown_table(inside)),
      parameters.empty() ? Markdown() : Markdown::of("\n{}", parameters));
}

/// Whether two runs differ in their seeds alone, and in the models that they have.
bool comparable(const ComparedRun& a, const ComparedRun& b) {
  return a.evaluation.scene == b.evaluation.scene && a.problem == b.problem &&
         std::ranges::all_of(a.fits, [&](const auto& fit) {
           const auto same = b.fits.find(fit.first);
           return same == b.fits.end() || same->second == fit.second;
         });
}

/// "run/a, run/b, run/c and 4 more"
std::string places_of(std::span<const ComparedRun> runs) {
  constexpr std::size_t kShown = 3;
  std::string text;
  for (std::size_t i = 0; i < std::min(kShown, runs.size()); ++i)
    text += (i == 0 ? "" : ", ") + printable(runs[i].place);
  return runs.size() > kShown ? fmt::format("{} and {} more", text, runs.size() - kShown) : text;
}

}  // namespace

Comparison compare_runs(std::span<const ComparedRun> runs, const std::string& against) {
  std::vector<std::vector<ComparedRun>> groups;
  std::map<std::string, int> groups_named;
  for (const ComparedRun& run : runs) {
    auto group = std::ranges::find_if(groups, [&](const std::vector<ComparedRun>& others) {
      return std::ranges::all_of(others, [&](const auto& other) { return comparable(run, other); });
    });
    if (group == groups.end()) {
      group = groups.insert(group, std::vector<ComparedRun>());
      ++groups_named[run.evaluation.scene];
    }
    group->push_back(run);
  }
  Comparison comparison;
  for (const std::vector<ComparedRun>& group : groups) {
    const std::string& name = group.front().evaluation.scene;
    comparison.scenes.push_back(compare_scene(
        groups_named[name] == 1 ? name : fmt::format("{} ({})", name, places_of(group)), group,
        against));
  }
  if (std::ranges::all_of(comparison.scenes,
                          [&](const ComparedScene& scene) { return scene.against != against; }))
    throw UserError("no model \"{}\"; allowed: one of the runs", against);
  return comparison;
}

std::string to_markdown(const Comparison& comparison) {
  Markdown text = Markdown::of(
      "# Runs compared\n\n"
      "Mean squared error of q [rad²]: geometric mean over the runs of a scene, each of them the "
      "geometric mean over its trajectories, start times and seeds, with a 90 % Student t interval "
      "over the runs. Against convention, or against a model: over the best conventional model, or "
      "that model, of the same run. "
      "Headroom closed: 0 as good as the best conventional model, 1 as good as the oracle.\n");
  for (const ComparedScene& scene : comparison.scenes)
    text += Markdown::of("\n{}", markdown(scene));
  return text.text();
}

}  // namespace fricid::evaluate
