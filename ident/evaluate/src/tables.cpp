#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "fricid/base/csv.hpp"
#include "fricid/evaluate/averages.hpp"
#include "fricid/evaluate/evaluate.hpp"
#include "fricid/evaluate/warnings.hpp"
#include "markdown.hpp"

namespace fricid::evaluate {
namespace {

bool has_any(const std::vector<double>& values) {
  return std::any_of(values.begin(), values.end(), [](double v) { return !std::isnan(v); });
}

bool has_friction(const Evaluation& report) {
  return std::any_of(report.summary.begin(), report.summary.end(),
                     [](const Summary& summary) { return !std::isnan(summary.friction); });
}

Markdown error_table(const Evaluation& report) {
  std::vector<Cells> rows{horizon_titles(Markdown::of("model"), report.horizons_s)};
  const bool friction = has_friction(report);
  if (friction) rows[0].emplace_back(Markdown::of("friction %"));
  for (const Markdown& title :
       {Markdown::of("diverged"), Markdown::of("parameters"), Markdown::of("budget")})
    rows[0].push_back(title);
  const auto add_bound = [&](const Markdown& title, const std::vector<double>& values) {
    if (!has_any(values)) return;
    append(rows.emplace_back(Cells{title}), values, digits);
    rows.back().resize(rows[0].size());
  };
  for (std::size_t i = 0; i < report.summary.size(); ++i) {
    const Summary& summary = report.summary[i];
    if (!summary.is_oracle && (i == 0 || report.summary[i - 1].is_oracle))
      add_bound(Markdown::of("*floor*"), report.floor);
    Cells& row = rows.emplace_back(Cells{
        summary.doubts.empty() ? escaped(summary.label)
                               : Markdown::of("{} (not to be trusted)", escaped(summary.label))});
    append(row, summary.q_mse_geometric_mean, digits);
    if (friction) row.push_back(percent(summary.friction));
    row.push_back(Markdown::of("{}/{}", summary.diverged, summary.rollouts));
    row.push_back(summary.is_oracle ? Markdown::of("–") : Markdown::of("{}", summary.parameters));
    row.push_back(summary.budget.empty() ? Markdown::of("–") : escaped(summary.budget));
  }
  add_bound(Markdown::of("*headroom*"), report.headroom);
  return markdown_table(rows);
}

Markdown floor_table(const Evaluation& report) {
  std::vector<Cells> rows{horizon_titles(Markdown::of("benchmark"), report.horizons_s)};
  const auto add = [&](const Markdown& title, const std::vector<double>& values) {
    append(rows.emplace_back(Cells{title}), values, digits);
  };
  add(Markdown::of("oracle"), report.oracle);
  add(Markdown::of("halving the truth's step"), report.halving);
  add(Markdown::of("floor"), report.floor);
  add(Markdown::of("engine against simulator"), report.integration);
  add(Markdown::of("best conventional"), report.best_conventional);
  add(Markdown::of("headroom"), report.headroom);
  return markdown_table(rows);
}

Markdown closed_table(const Evaluation& report) {
  std::vector<Cells> rows{horizon_titles(Markdown::of("headroom closed"), report.horizons_s)};
  for (const Summary& summary : report.summary)
    append(rows.emplace_back(Cells{escaped(summary.label)}), summary.headroom_closed, fixed);
  return markdown_table(rows);
}

Markdown interval_table(const Evaluation& report) {
  std::vector<Cells> rows{horizon_titles(Markdown::of("90 % interval"), report.horizons_s)};
  rows[0].push_back(Markdown::of("over"));
  for (const Summary& summary : report.summary) {
    Cells& row = rows.emplace_back(Cells{escaped(summary.label)});
    for (const Interval& i : summary.interval_90) row.push_back(range(i));
    row.push_back(summary.seeds > 1 ? Markdown::of("{} seeds", summary.seeds)
                                    : escaped(summary.interval_over));
  }
  return markdown_table(rows);
}

Markdown ensemble_table(const Evaluation& report) {
  std::vector<Cells> rows{horizon_titles(Markdown::of("seeds together"), report.horizons_s)};
  for (const double h : report.horizons_s) rows[0].push_back(Markdown::of("inside {}", seconds(h)));
  for (const Summary& summary : report.summary) {
    if (summary.ensemble_q_mse.empty()) continue;
    Cells& row = rows.emplace_back(
        Cells{Markdown::of("{} ({} seeds)", escaped(summary.label), summary.seeds)});
    append(row, summary.ensemble_q_mse, digits);
    append(row, summary.ensemble_coverage, percent);
  }
  return rows.size() == 1 ? Markdown() : markdown_table(rows);
}

Markdown band_table(const Evaluation& report) {
  std::vector<Cells> rows{{Markdown::of("90 % band")}};
  for (const double h : report.horizons_s) rows[0].push_back(Markdown::of("inside {}", seconds(h)));
  for (const double h : report.horizons_s) rows[0].push_back(Markdown::of("+- {}", seconds(h)));
  for (const Summary& summary : report.summary) {
    if (summary.band_coverage.empty()) continue;
    Cells& row = rows.emplace_back(Cells{escaped(summary.label)});
    append(row, summary.band_coverage, percent);
    append(row, summary.band_half_width, digits);
  }
  return rows.size() == 1 ? Markdown() : markdown_table(rows);
}

Markdown friction_table(const Evaluation& report) {
  std::vector<Cells> rows{{Markdown::of("friction torque"), Markdown::of("all"),
                           Markdown::of("presliding"), Markdown::of("reversal"),
                           Markdown::of("sliding"), Markdown::of("along the rollout")}};
  for (const Summary& s : report.summary) {
    Cells& row = rows.emplace_back(Cells{escaped(s.label)});
    append(row,
           std::initializer_list<double>{s.friction, s.friction_presliding, s.friction_reversal,
                                         s.friction_sliding, s.friction_rollout},
           percent);
  }
  return markdown_table(rows);
}

Markdown doubts(const Evaluation& report) {
  Markdown text;
  for (const Summary& summary : report.summary)
    for (const std::string& doubt : summary.doubts)
      text += Markdown::of("- {}: {}\n", escaped(summary.label), escaped(doubt));
  if (text.empty()) return {};
  return Markdown::of("\nNot to be trusted, and excluded from the best models:\n\n") + text;
}

Markdown unexplained(const Evaluation& report) {
  if (report.unexplained.empty()) return {};
  Markdown text =
      Markdown::of("\nRecordings that do not belong, on which no model can be judged:\n\n");
  for (const Unexplained& torque : report.unexplained) {
    const Warning warning = warning_of(torque);
    text += Markdown::of("- {}: {}; {}; remedy: {}\n", escaped(warning.subject),
                         escaped(warning.found), escaped(warning.meaning), escaped(warning.remedy));
  }
  return text;
}

}  // namespace

std::string to_markdown(const Evaluation& report) {
  const bool has_oracle = has_any(report.oracle);
  Markdown text = Markdown::of("# {}: open loop on held-out data\n\n", escaped(report.scene));
  text += Markdown::of(
      "Mean squared error of q [rad²] from the start of a rollout to the horizon, geometric mean "
      "over {} trajectories, start times and seeds. Diverged rollouts count, clamped.{}\n\n",
      report.trajectories.size(),
      has_friction(report) ? Markdown::of(" Friction: error of the friction torque driven by the "
                                          "measured motion, percent of its "
                                          "RMS; that of the oracle comes from the motion filter.")
                           : Markdown());
  text += error_table(report);
  text += doubts(report);
  text += unexplained(report);
  text += Markdown::of(
      "\nBudget: residuals over all rows of a joint that the conventional fit evaluated, all "
      "joints together; steps of training on torque or windows; iterations of "
      "expectation-maximisation. Training and EM begin at a conventional fit.\n");
  if (has_oracle) {
    text += Markdown::of(
        "\nThe oracle is the true model under the same noisy torque; the floor is the larger of "
        "its error and the change from halving the truth's physics step; headroom is the best "
        "conventional model over the oracle.\n\n");
    text += floor_table(report);
    text += Markdown::of(
        "\nHeadroom closed: 0 as good as the best conventional model, 1 as good as physics "
        "allows.\n\n");
    text += closed_table(report);
  }
  if (!has_oracle && has_any(report.floor))
    text += Markdown::of(
        "\nA log holds no truth. If its motion repeats, the floor is half the MSE between "
        "rollouts under the torques of two successive periods, smallest over the models; "
        "headroom is the best conventional model over the floor.\n");
  text += Markdown::of("\n{}", interval_table(report));
  if (const Markdown ensembles = ensemble_table(report); !ensembles.empty())
    text += Markdown::of(
                "\nSeeds of a model as an ensemble, rollouts from the first sample: MSE of their "
                "mean, and "
                "percent of the samples inside their 90 % band.\n\n") +
            ensembles;
  if (const Markdown bands = band_table(report); !bands.empty())
    text += Markdown::of(
                "\nOpen-loop 90 % bands from the first sample, under random torques of the size of "
                "the torque error on the training data: percent of the samples of q inside, "
                "half width [rad], root mean square.\n\n") +
            bands;
  if (const Markdown parameters = parameter_table(report.summary); !parameters.empty())
    text +=
        Markdown::of(
            "\nNominal 90 % intervals of parameters, 1.645 standard errors on either side, that "
            "hold the truth: of the rigid body, and of laws that the truth has.\n\n") +
        parameters;
  if (has_friction(report)) {
    text += Markdown::of(
        "\nError of the friction torque, percent of its RMS, mean over joints. Driven by the "
        "measured motion, but for the last column.\n\n");
    text += friction_table(report);
  }
  for (const std::string& why : report.meaningless)
    if (!why.empty()) text += Markdown::of("\nMeaningless: {}.\n", escaped(why));
  return text.text();
}

std::string short_table(const Evaluation& report,
                        const std::map<std::string, double>& measured_seconds) {
  const std::vector<double>& horizons = report.horizons_s;
  const std::vector<std::size_t> quoted = quoted_horizons(horizons);
  const std::size_t last = quoted.back(), first = quoted.front() < last ? quoted.front() : 0;
  const bool friction = has_friction(report);
  std::vector<Cells> rows{
      {Markdown::of("MSE(q) [rad²]"), Markdown::of("{}", seconds(horizons[first])),
       Markdown::of("{}", seconds(horizons[last])),
       friction ? Markdown::of("friction %") : Markdown::of("torque %"), Markdown::of("fit s")}};
  for (const Summary& summary : report.summary) {
    rows.push_back(
        {summary.doubts.empty() ? escaped(summary.label)
                                : Markdown::of("{} (not to be trusted)", escaped(summary.label)),
         digits(summary.q_mse_geometric_mean[first]), digits(summary.q_mse_geometric_mean[last]),
         percent(friction ? summary.friction : torque_left(report, summary.name)),
         digits(fit_seconds(summary, measured_seconds))});
  }
  return markdown_table(rows).text();
}

std::string to_csv(const Evaluation& report) {
  std::string text =
      "model,label,seed,is_oracle,trajectory,start_s,horizon_s,diverged,q_mse,q_mae,v_mse,v_mae\n";
  const auto cell = [](double value) {
    return std::isnan(value) ? std::string() : fmt::format("{}", value);
  };
  for (const ModelResult& model : report.models)
    for (const RolloutScore& score : model.scores)
      for (std::size_t h = 0; h < report.horizons_s.size(); ++h) {
        const HorizonErrors& error = score.error;
        if (std::isnan(error.q_mse[h])) continue;
        text += fmt::format(
            "{},{},{},{},{},{},{},{},{},{},{},{}\n", model.name, csv_cell(model.label), model.seed,
            model.is_oracle ? 1 : 0,
            csv_cell(report.trajectories[static_cast<std::size_t>(score.trajectory)], false),
            cell(score.start_s), cell(report.horizons_s[h]), score.diverged ? 1 : 0,
            cell(error.q_mse[h]), cell(error.q_mae[h]), cell(error.v_mse[h]), cell(error.v_mae[h]));
      }
  return text;
}

}  // namespace fricid::evaluate
