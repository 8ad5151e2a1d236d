#include <algorithm>
#include <cmath>

#include "html.hpp"
#include "json_files.hpp"
#include "report_parts.hpp"

namespace fricid::render {
namespace {

using html::Row;
using nlohmann::json;

std::string model_label(const json& summary) {
  return html::escaped(summary.value("label", summary.value("name", "")));
}

/// "15.7 s" as in a table head.
std::string horizon(double seconds) { return fmt::format("{:.3g}&#8239;s", seconds); }

std::string angle(double mse) {
  const double rms = std::sqrt(mse);
  return rms < 1 ? html::number(1e3 * rms) + "&#8239;mrad" : html::number(rms) + "&#8239;rad";
}

/// Logarithmic mean over horizons: what "best" means.
double overall(const json& summary) {
  double sum = 0;
  int count = 0;
  for (const double mse : numbers_in(summary, "q_mse_geometric_mean"))
    if (std::isfinite(mse) && mse > 0) {
      sum += std::log(mse);
      ++count;
    }
  return count > 0 ? sum / count : INFINITY;
}

std::vector<json> fitted_summaries(const json& evaluation) {
  std::vector<json> fitted;
  for (const json& summary : evaluation.at("summary"))
    if (!summary.value("is_oracle", false)) fitted.push_back(summary);
  return fitted;
}

/// Horizons to speak of: 1 s, or else the second, and the longest.
std::vector<std::size_t> spoken(const std::vector<double>& horizons) {
  const auto second = std::find(horizons.begin(), horizons.end(), 1.0);
  const auto first = second != horizons.end() ? second - horizons.begin()
                                              : std::ptrdiff_t{horizons.size() > 2 ? 1 : 0};
  std::vector<std::size_t> chosen{static_cast<std::size_t>(first)};
  if (chosen.front() + 1 < horizons.size()) chosen.push_back(horizons.size() - 1);
  return chosen;
}

std::string best_sentence(const json& evaluation, const json& best, std::size_t fitted) {
  const std::vector<double> horizons = numbers_in(evaluation, "horizons_s"),
                            mse = numbers_in(best, "q_mse_geometric_mean");
  const std::size_t trajectories = evaluation.at("trajectories").size();
  std::vector<std::string> errors, others;
  for (const std::size_t h : spoken(horizons))
    errors.push_back(angle(mse.at(h)) + " within " + horizon(horizons[h]));
  for (std::size_t h = 0; h < horizons.size(); ++h)
    for (const json& other : fitted_summaries(evaluation))
      if (numbers_in(other, "q_mse_geometric_mean").at(h) < 0.95 * mse.at(h))
        if (const std::string label = model_label(other);
            std::find(others.begin(), others.end(), label) == others.end())
          others.push_back(label);
  return fmt::format(
      "Of {} model{} of <b>{}</b>, <b>{}</b> follows {} best: started at the measured state and "
      "driven by the measured motor torque alone, it is off by {} (RMS over joints, typical "
      "start){}.",
      fitted, fitted == 1 ? "" : "s", html::escaped(evaluation.value("scene", "")),
      model_label(best),
      trajectories == 1 ? std::string("the held-out trajectory")
                        : fmt::format("{} held-out trajectories", trajectories),
      html::enumeration(errors),
      others.empty() ? ""
                     : fmt::format("; at single horizons {} {} better", html::enumeration(others),
                                   others.size() == 1 ? "is" : "are"));
}

std::string oracle_sentence(const Record& record, const json& best) {
  const json& evaluation = record.run.evaluation;
  const std::vector<double> horizons = numbers_in(evaluation, "horizons_s"),
                            oracle = numbers_in(evaluation, "oracle"),
                            ratio = numbers_in(best, "ratio_to_oracle"),
                            closed = numbers_in(best, "headroom_closed");
  std::vector<std::string> errors, ratios, shares;
  for (const std::size_t h : spoken(horizons)) {
    if (h >= oracle.size() || !std::isfinite(oracle[h])) continue;
    errors.push_back(angle(oracle[h]));
    ratios.push_back(html::number(ratio.at(h)));
    if (std::isfinite(closed.at(h))) shares.push_back(html::percent(closed[h]));
  }
  if (errors.empty()) {
    double left = kNaN;
    for (const RunModel& model : record.run.fitted())
      if (model.name == best.value("name", "")) left = torque_left(record.run, model);
    return "A log holds no truth, so how much better a model could be is not known" +
           (std::isnan(left) ? std::string(".")
                             : fmt::format("; along the measured motion {} leaves {} of the "
                                           "motor torque's RMS unexplained.",
                                           model_label(best), html::percent(left)));
  }
  std::string text = fmt::format(
      "The true model under the same noisy torque is off by {}, so in squared error {} is {} "
      "times worse than physics allows",
      html::enumeration(errors), model_label(best), html::enumeration(ratios));
  if (best.value("is_conventional", true)) return text + ": headroom that no model here closes.";
  return text + fmt::format(
                    "; of the logarithmic distance between the best conventional model "
                    "and the oracle it closes {}.",
                    html::enumeration(shares));
}

std::string failure_sentence(const Record& record, const json& best) {
  const json& evaluation = record.run.evaluation;
  std::vector<std::string> failures;
  for (const json& summary : fitted_summaries(evaluation))
    if (const int diverged = summary.value("diverged", 0); diverged > 0)
      failures.push_back(fmt::format("{} diverges in {} of {} rollouts", model_label(summary),
                                     diverged, summary.value("rollouts", 0)));
  if (failures.size() > 4) {
    const std::size_t all = failures.size();
    failures.assign({fmt::format("rollouts of {} models diverge", all)});
  }
  int unusable = 0, limited = 0, bounds = 0;
  for (const FittedModel& fitted : record.fits) {
    unusable += !fitted.fit.value("usable", true);
    limited += fitted.fit.value("outcome", "") == "iteration limit";
    for (const json& joint : fitted.fit.value("joints", json::array()))
      bounds += static_cast<int>(joint.value("at_bound", json::array()).size());
  }
  if (unusable > 0)
    failures.push_back(fmt::format("{} fit{} failed {} own health test", unusable,
                                   unusable == 1 ? "" : "s", unusable == 1 ? "its" : "their"));
  if (limited > 0)
    failures.push_back(fmt::format("{} fit{} stopped at {} limit of iterations", limited,
                                   limited == 1 ? "" : "s", limited == 1 ? "its" : "their"));
  if (bounds > 0)
    failures.push_back(
        fmt::format("{} parameter{} ended on a bound", bounds, bounds == 1 ? "" : "s"));
  std::vector<std::string> blind;
  const std::vector<double> horizons = numbers_in(evaluation, "horizons_s");
  const json meaningless = evaluation.value("meaningless", json::array());
  for (std::size_t h = 0; h < meaningless.size() && h < horizons.size(); ++h)
    if (meaningless[h].is_string()) blind.push_back(horizon(horizons[h]));
  if (!blind.empty())
    failures.push_back(fmt::format("the horizon{} of {} cannot rank models",
                                   blind.size() == 1 ? "" : "s", html::enumeration(blind)));

  std::string text = failures.empty()
                         ? "Nothing failed: no rollout diverged and every fit converged"
                         : "What fails: " + html::enumeration(failures);
  const double reversal = number_in(best, "friction_reversal"),
               sliding = number_in(best, "friction_sliding");
  if (std::isfinite(reversal) && std::isfinite(sliding))
    text += fmt::format(
        "; the friction torque of {} errs by {} of its RMS around reversals against {} in sliding",
        model_label(best), html::percent(reversal), html::percent(sliding));
  return text + ".";
}

const RunModel* find_model(const Run& run, const std::string& name) {
  for (const RunModel& model : run.models)
    if (model.name == name) return &model;
  return nullptr;
}

/// Marks the least finite number of a column among fitted models.
void mark_best(std::vector<Row>& rows, const std::vector<std::vector<double>>& values,
               std::size_t column, std::size_t cell) {
  std::size_t best = rows.size();
  for (std::size_t r = 0; r < rows.size(); ++r)
    if (column < values[r].size() && std::isfinite(values[r][column]) &&
        (best == rows.size() || values[r][column] < values[best][column]))
      best = r;
  if (best < rows.size()) rows[best].cells[cell].style = "best";
}

std::string score_table(const Record& record) {
  const json& evaluation = record.run.evaluation;
  const std::vector<double> horizons = numbers_in(evaluation, "horizons_s");
  const bool truth = record.run.truth.has_value();
  std::vector<std::string> head{"model"};
  for (const double h : horizons) head.push_back(horizon(h));
  if (truth) head.emplace_back("friction");
  for (const char* name : {"diverged", "parameters", "fit"}) head.emplace_back(name);
  const json& summaries = evaluation.at("summary");
  const bool budgets = std::any_of(summaries.begin(), summaries.end(), [](const json& summary) {
    return !summary.value("budget", "").empty();
  });
  if (budgets) head.emplace_back("budget");

  std::vector<Row> oracles, rows;
  std::vector<std::vector<double>> values;
  for (const json& summary : summaries) {
    const RunModel* model = find_model(record.run, summary.value("name", ""));
    if (model == nullptr) continue;
    Row row{{{dotted(*model)}}};
    const std::vector<double> mse = numbers_in(summary, "q_mse_geometric_mean");
    for (const double value : mse) row.cells.push_back({html::number(value)});
    if (truth) row.cells.push_back({html::percent(number_in(summary, "friction"))});
    const int diverged = summary.value("diverged", 0);
    row.cells.push_back(
        {fmt::format("{}/{}", diverged, summary.value("rollouts", 0)), diverged > 0 ? "bad" : ""});
    row.cells.push_back(
        {model->is_oracle ? "" : fmt::format("{}", summary.value("parameters", 0))});
    row.cells.push_back(
        {model->is_oracle ? "" : html::number(number_in(summary, "fit_seconds")) + "&#8239;s"});
    if (budgets) row.cells.push_back({html::escaped(summary.value("budget", ""))});
    (model->is_oracle ? oracles : rows).push_back(row);
    if (!model->is_oracle) values.push_back(mse);
  }
  for (std::size_t h = 0; h < horizons.size(); ++h) mark_best(rows, values, h, h + 1);

  const auto extra = [&](const std::string& name, const char* key) {
    const std::vector<double> list = numbers_in(evaluation, key);
    if (std::none_of(list.begin(), list.end(), [](double x) { return std::isfinite(x); }))
      return Row{};
    Row row{{{name}}, "soft"};
    for (const double value : list) row.cells.push_back({html::number(value)});
    row.cells.resize(head.size());
    return row;
  };
  std::vector<Row> all = oracles;
  Row floor = extra("floor", "floor");
  const bool has_floor = !floor.cells.empty();
  if (has_floor) all.push_back(std::move(floor));
  if (!rows.empty() && !all.empty()) rows.front().style = "rule";
  all.insert(all.end(), rows.begin(), rows.end());
  if (Row headroom = extra("headroom", "headroom"); !headroom.cells.empty()) {
    headroom.style = "soft rule";
    all.push_back(headroom);
  }
  return html::table(
      head, all,
      "<b>Table 1.</b> Mean squared error of q [rad²] in open loop, from the start of a rollout to "
      "the horizon: geometric mean over trajectories, start times and seeds. Bold: the best fitted "
      "model." +
          std::string(truth ? " Friction: error of the friction torque driven by the measured "
                              "motion, share of its RMS; the oracle's is what filtering that "
                              "motion costs. Floor: the larger of the oracle's error and of what "
                              "halving the truth's inner step changes. Headroom: the best "
                              "conventional model over the oracle."
                      : has_floor ? " Floor: half of what the open loop under the torque of one "
                                    "period of a repeating motion differs from that under the "
                                    "next. Headroom: the best conventional model over it."
                                  : ""));
}

std::string oracle_table(const Record& record) {
  const json& evaluation = record.run.evaluation;
  if (!record.run.truth) return {};
  const std::vector<double> horizons = numbers_in(evaluation, "horizons_s");
  std::vector<std::string> head{"model"};
  for (const double h : horizons) head.push_back("ratio<br>" + horizon(h));
  for (const double h : horizons) head.push_back("closed<br>" + horizon(h));
  for (const char* name : {"pre-<br>sliding", "<br>reversal", "<br>sliding"})
    head.emplace_back(name);
  std::vector<Row> rows;
  for (const json& summary : fitted_summaries(evaluation)) {
    const RunModel* model = find_model(record.run, summary.value("name", ""));
    if (model == nullptr) continue;
    Row row{{{dotted(*model)}}};
    for (const double ratio : numbers_in(summary, "ratio_to_oracle"))
      row.cells.push_back({html::number(ratio)});
    for (const double closed : numbers_in(summary, "headroom_closed"))
      row.cells.push_back({std::isnan(closed) ? "–" : html::percent(closed)});
    for (const char* key : {"friction_presliding", "friction_reversal", "friction_sliding"})
      row.cells.push_back({html::percent(number_in(summary, key))});
    rows.push_back(std::move(row));
  }
  return html::table(
      head, rows,
      "<b>Table 2.</b> Ratio of the MSE to the oracle's; share of the headroom closed, "
      "log(best conventional / model) / log(best conventional / oracle): 0 as good as the best "
      "conventional model, 100&#8239;% as good as physics allows; and the error of the friction "
      "torque by regime, share of its RMS.");
}

/// Mean of a list over all rollouts of a model, at one horizon.
double mean_score(const json& evaluation, const std::string& name, const char* key, std::size_t h) {
  double sum = 0;
  int count = 0;
  for (const json& model : evaluation.at("models"))
    if (model.value("name", "") == name)
      for (const json& score : model.value("trajectories", json::array()))
        if (const auto list = numbers_in(score, key); h < list.size() && std::isfinite(list[h])) {
          sum += list[h];
          ++count;
        }
  return count > 0 ? sum / count : kNaN;
}

std::string mean_table(const Record& record) {
  const json& evaluation = record.run.evaluation;
  const std::vector<double> horizons = numbers_in(evaluation, "horizons_s");
  std::vector<std::string> head{"model"};
  for (const double h : horizons) {
    head.push_back("MSE<br>" + horizon(h));
    head.push_back("MAE<br>" + horizon(h));
  }
  std::vector<Row> rows;
  for (const RunModel& model : record.run.models) {
    Row row{{{dotted(model)}}};
    for (std::size_t h = 0; h < horizons.size(); ++h)
      for (const char* key : {"q_mse", "q_mae"})
        row.cells.push_back({html::number(mean_score(evaluation, model.name, key, h))});
    rows.push_back(std::move(row));
  }
  return "<details><summary>Arithmetic means: MSE and MAE</summary>" +
         html::table(head, rows,
                     "<b>Table 3.</b> MSE(q) [rad²] and MAE(q) [rad], arithmetic means over the "
                     "same rollouts: one bad rollout decides them.") +
         "</details>\n";
}

}  // namespace

std::string dotted(const RunModel& model) {
  return fmt::format("<i class=\"dot{}\" style=\"background:{}\"></i>{}",
                     model.is_oracle ? " ring" : "", model.look.colour, html::escaped(model.label));
}

double torque_left(const Run& run, const RunModel& model) {
  const auto path = run.file("predictions", model);
  if (path.empty()) return kNaN;
  const data::H5Reader file(path, "fricid.prediction/1");
  const RowMatrix tau = file.matrix("/tau"), predicted = file.matrix("/tau_predicted");
  double sum = 0;
  for (Eigen::Index j = 0; j < tau.cols(); ++j) {
    double left = 0, all = 0;
    for (Eigen::Index k = 0; k < tau.rows(); ++k) {
      if (!std::isfinite(tau(k, j)) || !std::isfinite(predicted(k, j))) continue;
      left += std::pow(tau(k, j) - predicted(k, j), 2);
      all += std::pow(tau(k, j), 2);
    }
    sum += std::sqrt(left / all);
  }
  return sum / static_cast<double>(tau.cols());
}

std::string summary_section(const Record& record) {
  const json& evaluation = record.run.evaluation;
  std::vector<json> fitted = fitted_summaries(evaluation);
  if (fitted.empty()) return "<p class=\"abstract\">No model was fitted.</p>\n";
  const json best =
      *std::min_element(fitted.begin(), fitted.end(),
                        [](const json& a, const json& b) { return overall(a) < overall(b); });
  return fmt::format("<p class=\"abstract\">{} {} {}</p>\n",
                     best_sentence(evaluation, best, fitted.size()), oracle_sentence(record, best),
                     failure_sentence(record, best));
}

std::string table_section(const Record& record) {
  return "<h2 id=\"result\">Result</h2>\n" + score_table(record) + oracle_table(record) +
         mean_table(record);
}

std::string video_section(const Record& record) {
  const auto folder = record.run.folder / "video";
  if (!std::filesystem::exists(folder)) return {};
  std::vector<std::string> names;
  for (const auto& entry : std::filesystem::directory_iterator(folder))
    if (entry.path().extension() == ".mp4") names.push_back(entry.path().filename().string());
  if (names.empty()) return {};
  std::sort(names.begin(), names.end());
  std::string text = "<h2 id=\"videos\">Videos</h2>\n";
  for (const std::string& name : names)
    text += fmt::format(
        "<figure><video controls preload=\"metadata\" src=\"video/{0}\"></video>"
        "<figcaption><a href=\"video/{0}\">video/{0}</a></figcaption></figure>\n",
        html::escaped(name));
  return text;
}

}  // namespace fricid::render
