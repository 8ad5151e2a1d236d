#include "fricid/evaluate/torque_summary.hpp"
#include "html.hpp"
#include "report_parts.hpp"

namespace fricid::render {
namespace {

using evaluate::TorqueSummary;
using html::Row;
using html::Style;
using Values = std::vector<double>;

const RunModel& model_of(const Record& record, const TorqueSummary& torque) {
  return *record.run.model(torque.model);
}

/// Models with a smaller error than every static law, with the number of joints.
Html comparison(const Record& record, const std::vector<TorqueSummary>& torques) {
  const std::vector<TorqueSummary> static_laws = evaluate::static_laws(torques);
  if (static_laws.empty()) return {};
  const Values least = evaluate::least_percent(static_laws);
  const auto label = [&](const TorqueSummary& torque) {
    return html::escaped(model_of(record, torque).label);
  };
  std::vector<Html> names, others;
  for (const TorqueSummary& torque : torques)
    if (torque.is_static_law)
      names.push_back(label(torque));
    else if (torque.trusted)
      others.push_back(Html::of("{} at {}", label(torque), evaluate::joints_below(torque, least)));
  if (others.empty()) return {};
  return Html::of("<p>Closer than every law without a state ({}), of {} joints: {}.</p>\n",
                  html::enumeration(names), least.size(), html::enumeration(others));
}

std::vector<Html> joints_head(const Run& run) {
  std::vector<Html> head = html::headings({"model"});
  for (int j = 0; j < run.n(); ++j) head.push_back(html::escaped(run.heading(j)));
  return head;
}

Html percent_table(const Record& record, const std::vector<TorqueSummary>& torques) {
  std::vector<Row> rows;
  const Values least = evaluate::least_percent(evaluate::trusted(torques));
  for (const TorqueSummary& torque : torques) {
    Row row{{{dotted(model_of(record, torque))}}};
    for (std::size_t j = 0; j < torque.percent.size(); ++j) {
      const bool best = torque.trusted && torque.percent[j] == least[j];
      row.cells.push_back({html::number(torque.percent[j]), best ? Style::kBest : Style::kPlain});
    }
    row.cells.push_back({html::escaped(torque.trusted ? "yes" : "no"),
                         torque.trusted ? Style::kPlain : Style::kBad});
    rows.push_back(std::move(row));
  }
  std::vector<Html> head = joints_head(record.run);
  head.push_back(html::escaped("trusted"));
  return html::table(
      head, rows,
      Html::of("Error of the motor torque along the measured motion [% of its RMS], mean over "
               "the held-out recordings. Friction is in open loop: driven by the measured "
               "motion, the measured torque never corrects it. Bold: the best "
               "model that passed its own checks."));
}

Html regime_table(const Record& record, const std::vector<TorqueSummary>& torques) {
  std::vector<Row> rows;
  for (const TorqueSummary& torque : torques) {
    Row row{{{dotted(model_of(record, torque))}}};
    for (const double percent :
         {torque.reversal, torque.presliding, torque.sliding, torque.one_step})
      row.cells.push_back({html::number(percent)});
    rows.push_back(std::move(row));
  }
  return html::table(
      html::headings({"model", "reversal", "presliding", "sliding", "one step"}), rows,
      Html::of("The same by regime, mean over joints [% of the torque's RMS]: within 50 ms "
               "of a reversal; below 0.05 rad/s or within 5 mrad of one; the rest. One step: the "
               "error less its lag-one autocorrelation times that of the last sample."));
}

Html drift_table(const Record& record, const std::vector<TorqueSummary>& torques) {
  std::vector<Row> rows;
  for (const TorqueSummary& torque : torques) {
    Row row{{{dotted(model_of(record, torque))}}};
    for (std::size_t j = 0; j < torque.drift.size(); ++j)
      row.cells.push_back({Html::of("{} ± {}", html::number(torque.drift[j]),
                                    html::number(torque.drift_error[j], 1)),
                           torque.drifts(j) ? Style::kBad : Style::kPlain});
    rows.push_back(std::move(row));
  }
  return html::table(joints_head(record.run), rows,
                     Html::of("Drift of the residual from start to end of a recording [N m], mean "
                              "over recordings, and its standard error; marked beyond three of "
                              "them: warming up, or a slow effect that the model lacks."));
}

/// Noise of the recordings, from their repetitions.
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
        "<p class=\"note\">No motion repeats in these recordings, so the noise part of the error "
        "is unknown: record two periods.</p>\n");
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
  std::vector<TorqueSummary> torques = evaluate::torque_summaries(record.run.evaluation);
  std::erase_if(torques, [&](const TorqueSummary& torque) {
    return record.run.model(torque.model) == nullptr;
  });
  if (torques.empty()) return {};
  const Html text = Html::of("<h2 id=\"torque\">Torque along the motion</h2>\n") +
                    percent_table(record, torques) + comparison(record, torques);
  const Html more = regime_table(record, torques) + drift_table(record, torques);
  if (record.run.truth) return text + html::details("By regime, and drift", Html::of("\n") + more);
  return text + more + repeats_table(record);
}

}  // namespace fricid::render
