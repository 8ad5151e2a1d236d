// Closed loops with the friction of models fed forward.
#include <cmath>

#include "html.hpp"
#include "report_parts.hpp"

namespace fricid::render {
namespace {

using evaluate::LoopScore;
using html::Row;
using html::Style;

/// A model of the run with its dot; what is none (nothing, the truth) by its label.
Html name_of(const Record& record, const std::string& name, const std::string& label) {
  const RunModel* model = record.run.model(name);
  return model == nullptr ? html::escaped(label) : dotted(*model);
}

Html milliseconds(double seconds) {
  return std::isfinite(seconds) ? html::number(1e3 * seconds, 3) : Html::of("missed");
}

}  // namespace

Html compensation_section(const Record& record) {
  if (!record.run.compensation) return {};
  const evaluate::CompensationFile& file = *record.run.compensation;
  std::vector<Row> rows;
  int path = 0, controller = 0;
  for (const LoopScore& loop : file.loops) {
    Row row{{{name_of(record, loop.model, loop.label)}}};
    const bool next = loop.path != path || loop.controller != controller;
    path = loop.path;
    controller = loop.controller;
    row.style = next ? Style::kRule : Style::kPlain;
    row.cells.push_back({html::number(loop.peak_rad_s)});
    row.cells.push_back({html::number(loop.bandwidth_hz)});
    row.cells.push_back({loop.gain > 0 ? html::number(loop.gain) : Html::of("–")});
    if (loop.diverged) {
      row.cells.push_back({Html::of("diverged"), Style::kBad});
      row.cells.resize(8);
    } else {
      row.cells.push_back({html::number(1e3 * evaluate::rms(loop.reversal_rad))});
      row.cells.push_back({html::number(1e3 * evaluate::rms(loop.sliding_rad))});
      row.cells.push_back({html::number(loop.feedback_J)});
      row.cells.push_back({Html::of("{}", loop.limit_cycles.size()),
                           loop.limit_cycles.empty() ? Style::kPlain : Style::kBad});
    }
    rows.push_back(std::move(row));
  }
  return Html::of("<h2 id=\"compensation\">Friction fed forward</h2>\n") +
         html::table(
             {html::escaped("model"), Html::of("fastest [rad/s]"), Html::of("controller [Hz]"),
              Html::of("gain"), Html::of("RMS at reversals [mrad]"), Html::of("in sliding [mrad]"),
              Html::of("feedback [J]"), Html::of("limit cycles")},
             rows,
             Html::of("The simulated arm under its controller, the friction of each model added to "
                      "the motor torque, its states driven by the {} motion. Reversals: 0.2 s from "
                      "each. Feedback: integral of its power. Limit cycles: joints that keep "
                      "swinging while the reference rests.",
                      html::escaped(file.drive)));
}

Html contact_section(const Record& record) {
  if (!record.run.contact || record.run.contact->models.empty()) return {};
  const evaluate::ContactFile& file = *record.run.contact;
  std::vector<Html> head{html::escaped("model"), Html::of("RMSE [N&#8239;m]"),
                         Html::of("at reversals"), Html::of("in sliding"),
                         Html::of("threshold [N&#8239;m]")};
  for (const evaluate::PushScore& force : file.models.front().forces) {
    head.push_back(Html::of("{}&#8239;N: delay [ms]", html::number(force.force_N, 3)));
    head.push_back(Html::of("90&#8239;% [ms]"));
    head.push_back(Html::of("missed"));
  }
  std::vector<Row> rows;
  for (const evaluate::ContactScore& score : file.models) {
    Row& row = rows.emplace_back();
    row.cells = {{name_of(record, score.model, score.label)},
                 {html::number(evaluate::rms(score.rmse_Nm))},
                 {html::number(evaluate::rms(score.rmse_reversal_Nm))},
                 {html::number(evaluate::rms(score.rmse_sliding_Nm))},
                 {html::number(evaluate::mean_threshold(score))}};
    for (const evaluate::PushScore& force : score.forces) {
      row.cells.push_back({milliseconds(force.delay_median_s)});
      row.cells.push_back({milliseconds(force.delay_90_s)});
      row.cells.push_back({Html::of("{}/{}", force.missed, force.pushes),
                           force.missed > 0 ? Style::kBad : Style::kPlain});
    }
  }
  return Html::of("<h2 id=\"contact\">External torque</h2>\n") +
         html::table(head, rows,
                     Html::of("Pushes on the simulated arm, seen by a momentum observer of {} Hz "
                              "with the friction of each model. RMSE over joints. Threshold of one "
                              "false alarm per hour, from {} h without contact: geometric mean "
                              "over joints. Delay from the begin of a push: median, and nine of "
                              "ten are faster.",
                              html::number(file.bandwidth_hz), html::number(file.hours)));
}

}  // namespace fricid::render
