#include "fricid/evaluate/compare.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "fricid/base/error.hpp"
#include "fricid/evaluate/evaluation_file.hpp"
#include "json.hpp"
#include "markdown.hpp"

namespace fricid::evaluate {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

double read_number(const Json& json) { return json.is_number() ? json.get<double>() : kNan; }

std::vector<double> read_numbers(const Json& json) {
  std::vector<double> values;
  for (const Json& item : json) values.push_back(read_number(item));
  return values;
}

/// The evaluation of one run.
struct Run {
  std::filesystem::path folder;
  Json json;

  std::string scene() const { return json.at("scene"); }
  std::vector<double> horizons() const { return read_numbers(json.at("horizons_s")); }
  std::vector<double> convention() const { return read_numbers(json.at("best_conventional")); }
  const Json* summary(const std::string& name) const {
    for (const Json& summary : json.at("summary"))
      if (summary.at("name") == name) return &summary;
    return nullptr;
  }
};

Run read_run(const std::filesystem::path& folder) { return {folder, load_evaluation(folder)}; }

ComparedModel compare_model(const std::string& name, std::span<const Run> runs,
                            std::size_t horizons) {
  ComparedModel model;
  model.name = name;
  std::vector<double> seconds_spent, friction;
  std::vector<std::vector<double>> errors(horizons), ratios(horizons);
  for (const Run& run : runs) {
    const Json* summary = run.summary(name);
    if (summary == nullptr) continue;
    model.label = summary->at("label");
    model.is_oracle = summary->at("is_oracle");
    model.is_conventional = summary->at("is_conventional");
    model.parameters = summary->at("parameters");
    model.diverged += summary->at("diverged").get<int>();
    model.rollouts += summary->at("rollouts").get<int>();
    model.runs += 1;
    seconds_spent.push_back(read_number(summary->at("fit_seconds")));
    friction.push_back(summary->contains("friction") ? read_number(summary->at("friction")) : kNan);
    const std::vector<double> q_mse = read_numbers(summary->at("q_mse_geometric_mean"));
    const std::vector<double> convention = run.convention();
    for (std::size_t h = 0; h < horizons; ++h) {
      errors[h].push_back(q_mse[h]);
      ratios[h].push_back(q_mse[h] / convention[h]);
    }
  }
  model.fit_seconds = mean(seconds_spent);
  model.friction = mean(friction);
  for (std::size_t h = 0; h < horizons; ++h) {
    model.q_mse.push_back(geometric_mean(errors[h]));
    model.interval_90.push_back(interval_90(errors[h]));
    model.against_convention.push_back(geometric_mean(ratios[h]));
    model.against_convention_90.push_back(interval_90(ratios[h]));
  }
  return model;
}

ComparedScene compare_scene(const std::string& name, std::span<const Run> runs) {
  ComparedScene scene;
  scene.scene = name;
  scene.runs = static_cast<int>(runs.size());
  scene.horizons_s = runs.front().horizons();
  std::vector<std::string> models;
  for (const Run& run : runs) {
    if (run.horizons() != scene.horizons_s)
      throw UserError(
          "{}: horizons differ from those of {}; allowed: runs of {} with the same ones",
          run.folder.string(), runs.front().folder.string(), name);
    for (const Json& summary : run.json.at("summary")) {
      const std::string model = summary.at("name");
      if (std::ranges::find(models, model) == models.end()) models.push_back(model);
    }
  }
  const std::size_t horizons = scene.horizons_s.size();
  for (const std::string& model : models)
    scene.models.push_back(compare_model(model, runs, horizons));

  const auto oracle = std::ranges::find(scene.models, true, &ComparedModel::is_oracle);
  for (std::size_t h = 0; h < horizons; ++h) {
    std::vector<double> conventions;
    for (const Run& run : runs) conventions.push_back(run.convention()[h]);
    const double convention = geometric_mean(conventions);
    const double floor = oracle == scene.models.end() ? kNan : oracle->q_mse[h];
    scene.headroom.push_back(convention / floor);
    for (ComparedModel& model : scene.models)
      model.headroom_closed.push_back(convention > floor ? std::log(convention / model.q_mse[h]) /
                                                               std::log(convention / floor)
                                                         : kNan);
  }
  return scene;
}

Markdown markdown(const ComparedScene& scene) {
  std::vector<Cells> errors{horizon_titles(Markdown::of("model"), scene.horizons_s)},
      ratios{horizon_titles(Markdown::of("against convention"), scene.horizons_s)},
      closed{horizon_titles(Markdown::of("headroom closed"), scene.horizons_s)};
  for (const Markdown& title :
       {Markdown::of("friction %"), Markdown::of("diverged"), Markdown::of("parameters"),
        Markdown::of("fit s"), Markdown::of("runs")})
    errors[0].push_back(title);
  const auto with_interval = [](double value, const Interval& interval) {
    return std::isnan(interval.low) ? digits(value)
                                    : Markdown::of("{} ({})", digits(value), range(interval));
  };
  for (const ComparedModel& model : scene.models) {
    Cells& error = errors.emplace_back(Cells{escaped(model.label)});
    Cells& ratio = ratios.emplace_back(Cells{escaped(model.label)});
    for (std::size_t h = 0; h < scene.horizons_s.size(); ++h) {
      error.push_back(with_interval(model.q_mse[h], model.interval_90[h]));
      ratio.push_back(with_interval(model.against_convention[h], model.against_convention_90[h]));
    }
    error.push_back(percent(model.friction));
    error.push_back(Markdown::of("{}/{}", model.diverged, model.rollouts));
    error.push_back(model.is_oracle ? Markdown::of("–") : Markdown::of("{}", model.parameters));
    error.push_back(model.is_oracle ? Markdown::of("–") : digits(model.fit_seconds));
    error.push_back(Markdown::of("{}", model.runs));
    append(closed.emplace_back(Cells{escaped(model.label)}), model.headroom_closed, fixed);
  }
  Cells& headroom = errors.emplace_back(Cells{Markdown::of("*headroom*")});
  append(headroom, scene.headroom, digits);
  headroom.resize(errors[0].size());
  return Markdown::of("## {}: {} run{}\n\n{}\n{}\n{}", escaped(scene.scene), scene.runs,
                      scene.runs == 1 ? Markdown() : Markdown::of("s"), markdown_table(errors),
                      markdown_table(ratios), markdown_table(closed));
}

}  // namespace

std::vector<ComparedScene> compare_runs(std::span<const std::filesystem::path> folders) {
  std::vector<std::string> order;
  std::map<std::string, std::vector<Run>> by_scene;
  for (const std::filesystem::path& folder : folders) {
    Run run = read_run(folder);
    std::vector<Run>& runs = by_scene[run.scene()];
    if (runs.empty()) order.push_back(run.scene());
    runs.push_back(std::move(run));
  }
  std::vector<ComparedScene> scenes;
  for (const std::string& name : order) scenes.push_back(compare_scene(name, by_scene.at(name)));
  return scenes;
}

std::string to_markdown(std::span<const ComparedScene> scenes) {
  Markdown text = Markdown::of(
      "# Runs compared\n\n"
      "Mean squared error of q [rad²]: geometric mean over the runs of a scene, each of them the "
      "geometric mean over its trajectories, start times and seeds, with a 90 % Student t interval "
      "over the runs. Against convention: model over the best conventional model of the same run. "
      "Headroom closed: 0 as good as the best conventional model, 1 as good as physics allows.\n");
  for (const ComparedScene& scene : scenes) text += Markdown::of("\n{}", markdown(scene));
  return text.text();
}

std::string to_json(std::span<const ComparedScene> scenes) {
  Json json = {{"format", "fricid.comparison/1"}, {"scenes", Json::array()}};
  for (const ComparedScene& scene : scenes) {
    Json models = Json::array();
    for (const ComparedModel& m : scene.models)
      models.push_back({{"name", m.name},
                        {"label", m.label},
                        {"is_oracle", m.is_oracle},
                        {"is_conventional", m.is_conventional},
                        {"runs", m.runs},
                        {"diverged", m.diverged},
                        {"rollouts", m.rollouts},
                        {"parameters", m.parameters},
                        {"fit_seconds", number(m.fit_seconds)},
                        {"friction", number(m.friction)},
                        {"q_mse_geometric_mean", numbers(m.q_mse)},
                        {"interval_90", intervals(m.interval_90)},
                        {"against_convention", numbers(m.against_convention)},
                        {"against_convention_90", intervals(m.against_convention_90)},
                        {"headroom_closed", numbers(m.headroom_closed)}});
    json["scenes"].push_back({{"scene", scene.scene},
                              {"runs", scene.runs},
                              {"horizons_s", numbers(scene.horizons_s)},
                              {"headroom", numbers(scene.headroom)},
                              {"models", models}});
  }
  return json.dump(2) + "\n";
}

}  // namespace fricid::evaluate
