#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "fricid/evaluate/averages.hpp"
#include "html.hpp"
#include "report_parts.hpp"

namespace fricid::render {
namespace {

using evaluate::TorquePrediction;
using html::Row;
using html::Style;
using Values = std::vector<double>;

struct Predicted {
  const RunModel* model;
  bool is_static_law;  ///< a convention whose friction has no state
  Values percent;      ///< (n) of the torque's RMS
};

std::vector<Predicted> predictions_of(const Record& record) {
  std::vector<Predicted> found;
  for (const RunModel& model : record.run.models) {
    Values percent = evaluate::mean_of_torque(record.run.evaluation, model.name,
                                              &TorquePrediction::percent_of_rms);
    if (percent.empty()) continue;
    bool is_static = false;
    for (const evaluate::ModelResult& own : record.run.evaluation.models)
      if (own.name == model.name) is_static = own.is_conventional && own.friction_states == 0;
    found.push_back({&model, is_static, std::move(percent)});
  }
  return found;
}

/// Which models err less than every static law, and at how many joints.
Html comparison(const std::vector<Predicted>& predictions) {
  Values least;
  std::vector<Html> names;
  for (const Predicted& prediction : predictions) {
    if (!prediction.is_static_law) continue;
    names.push_back(html::escaped(prediction.model->label));
    least.resize(prediction.percent.size(), INFINITY);
    for (std::size_t j = 0; j < least.size(); ++j)
      least[j] = std::min(least[j], prediction.percent[j]);
  }
  std::vector<Html> others;
  for (const Predicted& prediction : predictions) {
    if (prediction.is_static_law || least.empty()) continue;
    int better = 0;
    for (std::size_t j = 0; j < least.size(); ++j) better += prediction.percent[j] < least[j];
    others.push_back(Html::of("{} at {}", html::escaped(prediction.model->label), better));
  }
  if (others.empty()) return {};
  return Html::of("<p>Closer than every law without a state ({}), of {} joints: {}.</p>\n",
                  html::enumeration(names), least.size(), html::enumeration(others));
}

std::vector<Html> joints_head(const Run& run) {
  std::vector<Html> head = html::headings({"model"});
  for (int j = 0; j < run.n(); ++j) head.push_back(html::escaped(run.joint(j)));
  return head;
}

Html percent_table(const Record& record, const std::vector<Predicted>& predictions) {
  std::vector<Row> rows;
  Values least(predictions.front().percent.size(), INFINITY);
  for (const Predicted& prediction : predictions)
    for (std::size_t j = 0; j < least.size(); ++j)
      least[j] = std::min(least[j], prediction.percent[j]);
  for (const Predicted& prediction : predictions) {
    Row row{{{dotted(*prediction.model)}}};
    for (std::size_t j = 0; j < least.size(); ++j)
      row.cells.push_back({html::number(prediction.percent[j]),
                           prediction.percent[j] == least[j] ? Style::kBest : Style::kPlain});
    rows.push_back(std::move(row));
  }
  return html::table(
      joints_head(record.run), rows,
      Html::of("Error of the motor torque along the measured motion [% of its RMS], mean over "
               "the held-out recordings. Friction runs free: the measured motion drives it, "
               "the measured torque never corrects it. Bold: the best model."));
}

/// What a regime or a correction leaves, mean over joints of the share of the whole error.
Html regime_table(const Record& record, const std::vector<Predicted>& predictions) {
  std::vector<Row> rows;
  for (const Predicted& prediction : predictions) {
    Row row{{{dotted(*prediction.model)}}};
    const auto mean = [&](auto list) {
      return evaluate::mean_of_torque(record.run.evaluation, prediction.model->name, list);
    };
    const auto regime = [&](Values evaluate::RegimeError::*list) {
      return mean(
          [list](const TorquePrediction& torque) -> const Values& { return torque.rmse.*list; });
    };
    using evaluate::RegimeError;
    const Values all = regime(&RegimeError::all);
    for (const Values& own : {regime(&RegimeError::reversal), regime(&RegimeError::presliding),
                              regime(&RegimeError::sliding), mean(&TorquePrediction::one_step)}) {
      double sum = 0;
      int count = 0;
      for (std::size_t j = 0; j < own.size(); ++j)
        if (const double share = own[j] / all[j] * prediction.percent[j]; std::isfinite(share)) {
          sum += share;
          ++count;
        }
      row.cells.push_back({html::number(sum / count)});
    }
    rows.push_back(std::move(row));
  }
  return html::table(
      html::headings({"model", "reversal", "presliding", "sliding", "one step"}), rows,
      Html::of("The same by regime, mean over joints [% of the torque's RMS]: within 50 ms "
               "of a reversal; below 0.05 rad/s or within 5 mrad of one; the rest. One step: "
               "with the error of the last sample known, so what white noise leaves."));
}

Html drift_table(const Record& record, const std::vector<Predicted>& predictions) {
  constexpr double kCertain = 3;
  std::vector<Row> rows;
  for (const Predicted& prediction : predictions) {
    Row row{{{dotted(*prediction.model)}}};
    const evaluate::Evaluation& evaluation = record.run.evaluation;
    const std::string& name = prediction.model->name;
    const Values drift = evaluate::mean_of_torque(evaluation, name, &TorquePrediction::drift),
                 error = evaluate::mean_of_torque(evaluation, name, &TorquePrediction::drift_error);
    for (std::size_t j = 0; j < drift.size(); ++j)
      row.cells.push_back({Html::of("{} ± {}", html::number(drift[j]), html::number(error[j], 1)),
                           std::abs(drift[j]) > kCertain * error[j] ? Style::kBad : Style::kPlain});
    rows.push_back(std::move(row));
  }
  return html::table(joints_head(record.run), rows,
                     Html::of("Drift of what is left from begin to end of a recording [N m], mean "
                              "over recordings, and its standard error; marked beyond three of "
                              "them: warming up, or a slow motion that the model lacks."));
}

/// What the recordings say of their own noise.
Html repeats_table(const Record& record) {
  const evaluate::Evaluation& evaluation = record.run.evaluation;
  std::vector<Row> rows;
  for (std::size_t i = 0; i < evaluation.repeats.size(); ++i) {
    const evaluate::Repeats& motion = evaluation.repeats[i];
    if (motion.period_s == 0) continue;
    Row row{{{html::escaped(evaluation.trajectories[i])}, {html::number(motion.period_s, 4)}}};
    for (const double sd : motion.tau_sd) row.cells.push_back({html::number(sd)});
    rows.push_back(std::move(row));
  }
  if (rows.empty())
    return Html::of(
        "<p class=\"note\">No motion repeats in these recordings, so how much of the error is "
        "noise is not known: record two periods.</p>\n");
  std::vector<Html> head = joints_head(record.run);
  head.front() = html::escaped("recording");
  head.insert(head.begin() + 1, html::escaped("period [s]"));
  return html::table(head, rows,
                     Html::of("Repeatability: standard deviation of the torque of one passage of a "
                              "motion against the next [N m]. No function of the motion can err "
                              "by less."));
}

}  // namespace

Html torque_section(const Record& record) {
  const std::vector<Predicted> predictions = predictions_of(record);
  if (predictions.empty()) return {};
  const Html text = Html::of("<h2 id=\"torque\">Torque along the motion</h2>\n") +
                    percent_table(record, predictions) + comparison(predictions);
  const Html more = regime_table(record, predictions) + drift_table(record, predictions);
  if (record.run.truth) return text + html::details("By regime, and drift", Html::of("\n") + more);
  return text + more + repeats_table(record);
}

}  // namespace fricid::render
