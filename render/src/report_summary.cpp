#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "fricid/data/contract.hpp"
#include "fricid/evaluate/averages.hpp"
#include "fricid/evaluate/verdict.hpp"
#include "html.hpp"
#include "report_parts.hpp"

namespace fricid::render {
namespace {

using evaluate::Evaluation;
using evaluate::Summary;
using html::Row;
using html::Style;

Html model_label(const Summary& summary) { return html::escaped(evaluate::label_of(summary)); }

/// "15.7 s" as in a table head.
Html horizon(double seconds) { return Html::of("{:.3g}&#8239;s", seconds); }

Html angle(double mse) {
  const double rms = std::sqrt(mse);
  return rms < 1 ? Html::of("{}&#8239;mrad", html::number(1e3 * rms))
                 : Html::of("{}&#8239;rad", html::number(rms));
}

Html duration(double seconds) {
  return std::isnan(seconds) ? Html::of("–") : Html::of("{}&#8239;s", html::number(seconds));
}

std::vector<Html> labels_of(const std::vector<const Summary*>& summaries) {
  std::vector<Html> labels;
  for (const Summary* summary : summaries) labels.push_back(model_label(*summary));
  return labels;
}

Html best_sentence(const Evaluation& evaluation, const Summary& best) {
  const std::size_t fitted = evaluate::fitted_summaries(evaluation).size();
  const std::size_t trajectories = evaluation.trajectories.size();
  std::vector<Html> errors;
  for (const std::size_t h : evaluate::quoted_horizons(evaluation.horizons_s))
    errors.push_back(Html::of("{} within {}", angle(best.q_mse_geometric_mean[h]),
                              horizon(evaluation.horizons_s[h])));
  const std::vector<Html> others = labels_of(evaluate::better_at_a_horizon(evaluation, best));
  return Html::of(
      "Of {} model{} of <b>{}</b>, <b>{}</b> follows {} best: started at the measured state and "
      "driven by the measured motor torque alone, it is off by {} (RMS over joints, typical "
      "start){}.",
      fitted, html::plural(fitted), html::escaped(evaluation.scene), model_label(best),
      trajectories == 1 ? Html::of("the held-out trajectory")
                        : Html::of("{} held-out trajectories", trajectories),
      html::enumeration(errors),
      others.empty() ? Html()
                     : Html::of("; at single horizons {} {} better", html::enumeration(others),
                                others.size() == 1 ? Html::of("is") : Html::of("are")));
}

Html oracle_sentence(const Record& record, const Summary& best) {
  const Evaluation& evaluation = record.run.evaluation;
  std::vector<Html> errors, ratios, shares, reached;
  for (const std::size_t h : evaluate::quoted_horizons(evaluation.horizons_s)) {
    if (!std::isfinite(evaluation.oracle[h])) continue;
    errors.push_back(angle(evaluation.oracle[h]));
    ratios.push_back(html::number(best.ratio_to_oracle[h]));
    if (!(best.ratio_to_oracle[h] > 1)) reached.push_back(horizon(evaluation.horizons_s[h]));
    if (const double closed = best.headroom_closed[h]; std::isfinite(closed))
      shares.push_back(html::percent(closed));
  }
  if (errors.empty()) {
    const double left = evaluate::torque_left(evaluation, best.name);
    return Html::of("A log holds no truth, so the smallest possible error is unknown{}",
                    std::isnan(left) ? Html::of(".")
                                     : Html::of("; along the measured motion {} leaves {} of the "
                                                "motor torque's RMS unexplained.",
                                                model_label(best), html::percent(left)));
  }
  Html text = Html::of("The true model under the same noisy torque is off by {}",
                       html::enumeration(errors));
  text += reached.empty()
              ? Html::of(", so the squared error of {} is {} times the smallest possible one",
                         model_label(best), html::enumeration(ratios))
              : Html::of(
                    "; the squared error of {} is {} times as large, so within {} no model "
                    "can be told to be better",
                    model_label(best), html::enumeration(ratios), html::enumeration(reached));
  if (!best.is_conventional && !shares.empty())
    text += Html::of(
        "; of the logarithmic distance between the best conventional model and the oracle it "
        "closes {}",
        html::enumeration(shares));
  else if (reached.empty())
    text += Html::of(": no model here closes this headroom");
  return text + Html::of(".");
}

Html failure_sentence(const Record& record, const Summary& best) {
  std::vector<const data::FitFile*> fits;
  for (const FittedModel& fitted : record.fits)
    if (fitted.fit) fits.push_back(&*fitted.fit);
  const evaluate::Failures found = evaluate::failures_of(record.run.evaluation, fits);

  constexpr std::size_t kMostNamed = 4;
  std::vector<Html> failures;
  if (found.diverging.size() > kMostNamed)
    failures.push_back(Html::of("rollouts of {} models diverge", found.diverging.size()));
  else
    for (const Summary* summary : found.diverging)
      failures.push_back(Html::of("{} diverges in {} of {} rollouts", model_label(*summary),
                                  summary->diverged, summary->rollouts));
  const auto add_fits = [&](int count, std::string_view verb, std::string_view what) {
    if (count > 0)
      failures.push_back(
          Html::of("{} fit{} {} {} {}", count, html::plural(count), html::escaped(verb),
                   count == 1 ? Html::of("its") : Html::of("their"), html::escaped(what)));
  };
  add_fits(found.unusable_fits, "failed", "own checks");
  add_fits(found.limited_fits, "stopped at", "limit of iterations");
  if (found.at_bound > 0)
    failures.push_back(
        Html::of("{} parameter{} ended on a bound", found.at_bound, html::plural(found.at_bound)));
  if (const std::vector<double>& blind = found.blind_horizons; !blind.empty()) {
    std::vector<Html> names;
    for (const double seconds : blind) names.push_back(horizon(seconds));
    failures.push_back(Html::of("the horizon{} of {} cannot rank models",
                                html::plural(blind.size()), html::enumeration(names)));
  }

  Html text = failures.empty()
                  ? Html::of("Nothing failed: no rollout diverged and every fit converged")
                  : Html::of("What fails: {}", html::enumeration(failures));
  if (std::isfinite(best.friction_reversal) && std::isfinite(best.friction_sliding))
    text += Html::of(
        "; the friction torque of {} errs by {} of its RMS around reversals against {} in sliding",
        model_label(best), html::percent(best.friction_reversal),
        html::percent(best.friction_sliding));
  return text + Html::of(".");
}

/// Models that must not be trusted, shown before any figure.
Html distrust_section(const std::vector<const Summary*>& fitted) {
  Html text;
  for (const Summary* summary : fitted) {
    if (summary->doubts.empty()) continue;
    const std::size_t more = summary->doubts.size() - 1;
    text += Html::of("<p class=\"warning\"><b>{} is not to be trusted:</b> {}{}.</p>\n",
                     model_label(*summary), html::escaped(summary->doubts.front()),
                     more == 0 ? Html() : Html::of("; and {} more under warnings", more));
  }
  return text;
}

/// Per joint, over all fits: R2 of the training torque, and the verdict.
Html joint_table(const Record& record) {
  std::vector<evaluate::LabelledFit> fits;
  for (const FittedModel& fitted : record.fits)
    if (fitted.fit) fits.push_back({fitted.model.label, &*fitted.fit});
  std::vector<Row> rows;
  for (const evaluate::JointVerdict& joint :
       evaluate::joint_verdicts(record.run.measured.joint_names, fits)) {
    const data::FittedFault* fault = joint.fault;
    rows.push_back(
        {{{html::escaped(joint.joint)},
          {html::number(joint.least_r2, 3) +
           (joint.most_r2 > joint.least_r2 ? Html::of(" to {}", html::number(joint.most_r2, 3))
                                           : Html())},
          {html::escaped(fault == nullptr ? "passed"
                                          : fmt::format("not to be trusted ({}): {}; {}",
                                                        joint.model, fault->found, fault->remedy)),
           fault == nullptr ? Style::kPlain : Style::kBad}}});
  }
  if (rows.empty()) return {};
  return html::table({html::escaped("joint"), Html::of("R<sup>2</sup> of the training torque"),
                      html::escaped("verdict")},
                     rows, html::escaped("Every joint over all fits"));
}

/// Marks the least finite number of a column among rows.
/// @param values  of the rows that may be marked, empty of the others
void mark_best(std::vector<Row>& rows, const std::vector<std::vector<double>>& values,
               std::size_t column, std::size_t cell) {
  std::size_t best = rows.size();
  for (std::size_t r = 0; r < rows.size(); ++r)
    if (column < values[r].size() && std::isfinite(values[r][column]) &&
        (best == rows.size() || values[r][column] < values[best][column]))
      best = r;
  if (best < rows.size()) rows[best].cells[cell].style = Style::kBest;
}

Html score_table(const Record& record) {
  const Evaluation& evaluation = record.run.evaluation;
  const std::vector<double>& horizons = evaluation.horizons_s;
  const bool truth = record.run.truth.has_value();
  std::vector<Html> head = html::headings({"model"});
  for (const double h : horizons) head.push_back(horizon(h));
  if (truth) head.push_back(html::escaped("friction"));
  for (const char* name : {"trusted", "diverged", "parameters", "fit"})
    head.push_back(html::escaped(name));
  const bool budgets = std::ranges::any_of(
      evaluation.summary, [](const Summary& summary) { return !summary.budget.empty(); });
  if (budgets) head.push_back(html::escaped("budget"));

  std::vector<Row> oracles, rows;
  std::vector<std::vector<double>> values;
  for (const Summary& summary : evaluation.summary) {
    const RunModel* model = record.run.model(summary.name);
    if (model == nullptr) continue;
    Row row{{{dotted(*model)}}};
    const std::vector<double>& mse = summary.q_mse_geometric_mean;
    for (const double value : mse) row.cells.push_back({html::number(value)});
    if (truth) row.cells.push_back({html::percent(summary.friction)});
    const bool trusted = summary.doubts.empty();
    row.cells.push_back({html::escaped(model->is_oracle ? ""
                                       : trusted        ? "yes"
                                                        : "no"),
                         trusted ? Style::kPlain : Style::kBad});
    row.cells.push_back({Html::of("{}/{}", summary.diverged, summary.rollouts),
                         summary.diverged > 0 ? Style::kBad : Style::kPlain});
    row.cells.push_back({model->is_oracle ? Html() : Html::of("{}", summary.parameters)});
    row.cells.push_back({model->is_oracle ? Html()
                                          : duration(evaluate::fit_seconds(
                                                summary, workflow::fit_seconds(record.manifest)))});
    if (budgets) row.cells.push_back({html::escaped(summary.budget)});
    (model->is_oracle ? oracles : rows).push_back(row);
    if (!model->is_oracle) values.push_back(trusted ? mse : std::vector<double>());
  }
  for (std::size_t h = 0; h < horizons.size(); ++h) mark_best(rows, values, h, h + 1);

  const auto extra = [&](std::string_view name, const std::vector<double>& list) {
    if (std::none_of(list.begin(), list.end(), [](double x) { return std::isfinite(x); }))
      return Row{};
    Row row{{{html::escaped(name)}}, Style::kSoft};
    for (const double value : list) row.cells.push_back({html::number(value)});
    row.cells.resize(head.size());
    return row;
  };
  std::vector<Row> all = oracles;
  Row floor = extra("floor", evaluation.floor);
  const bool has_floor = !floor.cells.empty();
  if (has_floor) all.push_back(std::move(floor));
  if (!rows.empty() && !all.empty()) rows.front().style = Style::kRule;
  all.insert(all.end(), rows.begin(), rows.end());
  if (Row headroom = extra("headroom", evaluation.headroom); !headroom.cells.empty()) {
    headroom.style = Style::kSoftRule;
    all.push_back(headroom);
  }
  const Html more =
      truth ? Html::of(
                  " Friction: error of the friction torque driven by the measured motion, share of "
                  "its RMS; that of the oracle comes from the motion filter. Floor: the larger of "
                  "the oracle's error and the change from halving the truth's physics step. "
                  "Headroom: the best conventional model over the oracle.")
      : has_floor
          ? Html::of(
                " Floor: half the MSE between open loops under the torques of two successive "
                "periods of a repeating motion. Headroom: the best conventional model over the "
                "floor.")
          : Html();
  return html::table(
      head, all,
      Html::of("<b>Table 1.</b> Mean squared error of q [rad²] in open loop, from the start of a "
               "rollout to the horizon: geometric mean over trajectories, start times and seeds. "
               "Bold: the best fitted model that passed its own checks.{}",
               more));
}

Html oracle_table(const Record& record) {
  if (!record.run.truth) return {};
  const Evaluation& evaluation = record.run.evaluation;
  const std::vector<double>& horizons = evaluation.horizons_s;
  std::vector<Html> head = html::headings({"model"});
  for (const double h : horizons) head.push_back(Html::of("ratio<br>{}", horizon(h)));
  for (const double h : horizons) head.push_back(Html::of("closed<br>{}", horizon(h)));
  head.insert(head.end(),
              {Html::of("pre-<br>sliding"), Html::of("<br>reversal"), Html::of("<br>sliding")});
  std::vector<Row> rows;
  for (const Summary* summary : evaluate::fitted_summaries(evaluation)) {
    const RunModel* model = record.run.model(summary->name);
    if (model == nullptr) continue;
    Row row{{{dotted(*model)}}};
    for (const double ratio : summary->ratio_to_oracle) row.cells.push_back({html::number(ratio)});
    for (const double closed : summary->headroom_closed)
      row.cells.push_back({html::percent(closed)});
    for (const double error :
         {summary->friction_presliding, summary->friction_reversal, summary->friction_sliding})
      row.cells.push_back({html::percent(error)});
    rows.push_back(std::move(row));
  }
  return html::table(
      head, rows,
      Html::of(
          "<b>Table 2.</b> Ratio of the MSE to the oracle's; share of the headroom closed, "
          "log(best conventional / model) / log(best conventional / oracle): 0 as good as the best "
          "conventional model, 100&#8239;% as good as the oracle; and the error of the "
          "friction torque by regime, share of its RMS."));
}

Html mean_table(const Record& record) {
  const Evaluation& evaluation = record.run.evaluation;
  const std::vector<double>& horizons = evaluation.horizons_s;
  std::vector<Html> head = html::headings({"model"});
  for (const double h : horizons) {
    head.push_back(Html::of("MSE<br>{}", horizon(h)));
    head.push_back(Html::of("MAE<br>{}", horizon(h)));
  }
  std::vector<Row> rows;
  for (const RunModel& model : record.run.models) {
    Row row{{{dotted(model)}}};
    for (std::size_t h = 0; h < horizons.size(); ++h)
      for (const auto error : {&evaluate::HorizonErrors::q_mse, &evaluate::HorizonErrors::q_mae})
        row.cells.push_back({html::number(evaluate::mean_error(evaluation, model.name, error, h))});
    rows.push_back(std::move(row));
  }
  return html::details(
      "Arithmetic means: MSE and MAE",
      html::table(head, rows,
                  Html::of("<b>Table 3.</b> MSE(q) [rad²] and MAE(q) [rad], arithmetic means over "
                           "the same rollouts, dominated by the worst of them.")));
}

}  // namespace

Html dotted(const RunModel& model) {
  return Html::of("<i class=\"dot{}\" style=\"background:{}\"></i>{}",
                  model.is_oracle ? Html::of(" ring") : Html(), html::escaped(model.look.colour),
                  html::escaped(model.label));
}

Html summary_section(const Record& record) {
  const Evaluation& evaluation = record.run.evaluation;
  const std::vector<const Summary*> fitted = evaluate::fitted_summaries(evaluation);
  if (fitted.empty()) return Html::of("<p class=\"abstract\">No model was fitted.</p>\n");
  const std::string_view of_torque = data::warning_of_torque(record.run.measured);
  const Html verdicts =
      (of_torque.empty()
           ? Html()
           : Html::of("<p class=\"abstract\">Of the friction in this report: {}.</p>\n",
                      html::escaped(of_torque))) +
      distrust_section(fitted) + joint_table(record);
  const Summary* best = evaluate::best_model(evaluation);
  if (best == nullptr) return verdicts;
  return verdicts + Html::of("<p class=\"abstract\">{} {} {}</p>\n",
                             best_sentence(evaluation, *best), oracle_sentence(record, *best),
                             failure_sentence(record, *best));
}

Html table_section(const Record& record) {
  return Html::of("<h2 id=\"result\">Result</h2>\n") + score_table(record) + oracle_table(record) +
         mean_table(record);
}

Html video_section(const Record& record) {
  const workflow::RunFolder& folder = record.run.folder;
  Html text;
  for (const std::filesystem::path& video : folder.files_in(folder.videos(), ".mp4"))
    text += Html::of(
        "<figure><video controls preload=\"metadata\" src=\"{0}\"></video>"
        "<figcaption><a href=\"{0}\">{0}</a></figcaption></figure>\n",
        html::escaped(folder.name_of(video)));
  return text.empty() ? text : Html::of("<h2 id=\"videos\">Videos</h2>\n") + text;
}

}  // namespace fricid::render
