#include <algorithm>
#include <cmath>

#include "html.hpp"
#include "json_files.hpp"
#include "report_parts.hpp"

namespace fricid::render {
namespace {

using html::Cell;
using html::Row;
using nlohmann::json;

const json& child(const json& object, const std::string& key) {
  static const json kNothing = json::object();
  return object.is_object() && object.contains(key) ? object.at(key) : kNothing;
}

/// Injected value of a parameter where the truth has the same law at that joint; else NaN.
double true_value(const Run& run, int joint, const std::string& law, const std::string& symbol) {
  if (!run.truth) return kNaN;
  const friction::Friction& truth = run.truth->friction;
  const int i = friction::find_parameter(truth.model, joint, law, symbol);
  return i < 0 ? kNaN : truth.theta[static_cast<std::size_t>(i)];
}

bool is_at_bound(const json& fit, std::size_t joint, const std::string& symbol) {
  const json& joints = child(fit, "joints");
  if (!joints.is_array() || joint >= joints.size()) return false;
  const json& at_bound = child(joints[joint], "at_bound");
  return std::find(at_bound.begin(), at_bound.end(), symbol) != at_bound.end();
}

/// A number under `key` of a joint's fit, by symbol.
double of_joint(const json& fit, std::size_t joint, const char* key, const std::string& symbol) {
  const json& joints = child(fit, "joints");
  if (!joints.is_array() || joint >= joints.size()) return kNaN;
  return number_in(child(joints[joint], key), symbol);
}

std::string interval(double lower, double upper) {
  return fmt::format("{} … {}", html::number(lower), html::number(upper));
}

/// Parameters of one law as it appears at the joints: rows are symbols, columns joints.
std::string law_table(const Record& record, const FittedModel& fitted, const std::string& law,
                      int elements) {
  const Run& run = record.run;
  const json& joints = fitted.file.at("friction");
  std::vector<std::string> head{"parameter"};
  for (int j = 0; j < run.n(); ++j) head.push_back(html::escaped(run.joint(j)));
  head.emplace_back("allowed");

  int weights = 0;
  bool any_bound = false, any_truth = false, any_error = false, any_start = false;
  std::vector<Row> rows;
  for (const friction::ParameterInfo& info : friction::parameters_of_law(law, elements)) {
    const std::string symbol(info.symbol);
    if (info.role == friction::Role::kWeight) {
      ++weights;
      continue;
    }
    Row row{{{fmt::format("<span title=\"{}\">{}</span> <span class=\"soft\">{}</span>",
                          html::escaped(info.meaning), html::escaped(symbol),
                          info.has_unit() ? html::escaped(info.unit) : "")}}};
    Row start{{{"<span class=\"soft\">start</span>"}}, "soft"},
        truth{{{"<span class=\"soft\">truth</span>"}}, "soft"};
    bool has_truth = false, has_start = false;
    for (std::size_t j = 0; j < joints.size(); ++j) {
      const json* found = nullptr;
      for (const json& own : joints[j])
        if (own.value("law", "") == law) found = &own;
      const double value =
          found == nullptr ? kNaN : number_in(child(child(*found, "parameters"), symbol), "value");
      const double error = of_joint(fitted.fit, j, "standard_errors", symbol),
                   first = of_joint(fitted.fit, j, "start", symbol),
                   injected = true_value(run, static_cast<int>(j), law, symbol);
      Cell cell{html::number(value, 3)};
      if (std::isfinite(error)) {
        cell.text += " ± " + html::number(error, 1);
        any_error = true;
      }
      if (is_at_bound(fitted.fit, j, symbol)) {
        cell.text += "&#8239;†";
        cell.style = "bad";
        any_bound = true;
      }
      row.cells.push_back(cell);
      start.cells.push_back({html::number(first, 3)});
      truth.cells.push_back({html::number(injected, 3)});
      has_truth |= std::isfinite(injected);
      has_start |= std::isfinite(first);
    }
    row.cells.push_back({interval(info.lower, info.upper), "soft"});
    start.cells.emplace_back();
    truth.cells.emplace_back();
    rows.push_back(std::move(row));
    if (has_start) rows.push_back(std::move(start));
    if (has_truth) rows.push_back(std::move(truth));
    any_truth |= has_truth;
    any_start |= has_start;
  }
  std::string caption = fmt::format("Parameters of <i>{}</i>", html::escaped(law));
  if (elements > 0) caption += fmt::format(", {} elements", elements);
  if (any_error) caption += "; ± standard error";
  if (any_bound) caption += "; † ended on its bound";
  if (any_start) caption += "; start: where the search began";
  if (any_truth) caption += "; truth: as injected";
  std::string text = html::table(head, rows, caption + ".");
  if (weights > 0)
    text += fmt::format(
        "<p class=\"note\">And {} network weights per joint, in the model file.</p>\n", weights);
  return text;
}

std::string friction_tables(const Record& record, const FittedModel& fitted) {
  if (!fitted.file.is_object() || !fitted.file.contains("friction")) return {};
  std::vector<std::pair<std::string, int>> laws;
  for (const json& joint : fitted.file.at("friction"))
    for (const json& law : joint) {
      const std::pair entry(law.value("law", ""), law.value("elements", 0));
      if (std::find(laws.begin(), laws.end(), entry) == laws.end()) laws.push_back(entry);
    }
  std::string text;
  for (const auto& [law, elements] : laws) text += law_table(record, fitted, law, elements);
  if (const json& whole = child(fitted.file, "friction_of_robot"); whole.contains("parameters"))
    text += fmt::format(
        "<p class=\"note\">One <i>{}</i> for the whole robot, {} elements: {} weights and scales, "
        "in "
        "the model file.</p>\n",
        html::escaped(whole.value("law", "")), whole.value("elements", 0),
        whole.at("parameters").size());
  return text;
}

std::string base_table(const json& rigid) {
  const json& base = child(rigid, "base_parameters");
  if (!base.is_array() || base.empty()) return {};
  std::vector<Row> rows;
  for (const json& parameter : base) {
    const double value = number_in(parameter, "value"),
                 error = number_in(parameter, "standard_error"),
                 physical = number_in(parameter, "physical");
    const bool moved = std::abs(value - physical) > 3 * error;
    rows.push_back({{{html::escaped(parameter.value("name", "")), "text"},
                     {html::number(value, 4)},
                     {html::number(error, 2)},
                     {html::number(std::abs(error / value), 2)},
                     {html::number(physical, 4), moved ? "bad" : ""}}});
  }
  return "<details><summary>Base parameters of the rigid body</summary>" +
         html::table({"combination", "estimate", "standard error", "relative", "physical"}, rows,
                     "Base parameters [kg, kg m, kg m²]: what the data determine. Physical: those "
                     "of the nearest body with positive definite inertia, which the model uses; "
                     "marked where it lies more than three standard errors away.") +
         "</details>\n";
}

std::string body_table(const Record& record, const FittedModel& fitted) {
  const json& robot = child(fitted.file, "robot");
  const json& joints = child(robot, "joints");
  if (!joints.is_array()) return {};
  const json& rigid = child(fitted.fit, "rigid_body");
  const std::vector<double> used = numbers_in(rigid, "rows_used"),
                            total = numbers_in(rigid, "rows_total"),
                            residual = numbers_in(rigid, "residual_sd_Nm");
  std::vector<std::string> head{"joint"};
  for (int j = 0; j < record.run.n(); ++j) head.push_back(html::escaped(record.run.joint(j)));
  Row mass{{{"mass [kg]"}}}, armature{{{"armature [kg m²]"}}}, rows_used{{{"rows used"}}},
      noise{{{"residual of the regression [N m]"}}}, rms{{{"RMS of the torque residual [N m]"}}},
      r2{{{"R²"}}};
  const json& fits = child(fitted.fit, "joints");
  for (std::size_t j = 0; j < joints.size(); ++j) {
    mass.cells.push_back({html::number(number_in(child(joints[j], "moves"), "mass"), 3)});
    armature.cells.push_back({html::number(number_in(joints[j], "armature"), 3)});
    rows_used.cells.push_back(
        {j < used.size() && j < total.size() ? html::percent(used[j] / total[j]) : "–"});
    noise.cells.push_back({j < residual.size() ? html::number(residual[j]) : "–"});
    const json& fit = fits.is_array() && j < fits.size() ? fits[j] : fits;
    rms.cells.push_back({html::number(number_in(fit, "residual_rms_Nm"))});
    const double share = number_in(fit, "r2");
    r2.cells.push_back({std::isnan(share) ? "–" : fmt::format("{:.4f}", share)});
  }
  std::vector<Row> rows{mass, armature, rows_used, noise};
  if (fits.is_array() && !fits.empty()) rows.insert(rows.end(), {rms, r2});
  return html::table(head, rows,
                     "Rigid body of the model, and how its regression went. Masses and armatures "
                     "alone are not determined by the data; the base parameters are.") +
         base_table(rigid);
}

std::string health(const FittedModel& fitted) {
  const json& fit = fitted.fit;
  std::string text = "<dl>";
  const auto item = [&](const std::string& name, const std::string& value) {
    if (!value.empty()) text += fmt::format("<dt>{}</dt><dd>{}</dd>", name, value);
  };
  item("Method", html::escaped(fit.value("method", "")));
  item("Outcome", html::escaped(fit.value("outcome", "")) +
                      (fit.value("usable", true) ? "" : " <b class=\"bad\">not usable</b>"));
  item("In words", html::escaped(fit.value("message", "")));
  item("Fitted values", fmt::format("{}", fit.value("parameters", 0)));
  if (fit.contains("seconds")) item("Time", html::number(number_in(fit, "seconds")) + "&#8239;s");
  const json& rigid = child(fit, "rigid_body");
  if (rigid.contains("condition"))
    item("Condition of the regression", html::number(number_in(rigid, "condition")));
  if (const json& em = child(fit, "em"); em.contains("iterations")) {
    const json& iterations = em.at("iterations");
    if (!iterations.empty()) {
      item("Log-likelihood",
           fmt::format("{} → {}", html::number(number_in(iterations.front(), "log_likelihood"), 5),
                       html::number(number_in(iterations.back(), "log_likelihood"), 5)));
      item("NIS per channel", html::number(number_in(iterations.back(), "nis")) +
                                  " (1 where the noise is as large as the model says)");
    }
    item("Held-out MSE",
         html::number(number_in(em, "held_out_q_mse_start")) + " rad² at the start");
  }
  if (const json& torque = child(fit, "torque"); torque.contains("message"))
    item("Training on the torque", html::escaped(torque.value("message", "")));
  if (const json& multi = child(fit, "multi_step"); multi.contains("held_out_q_mse")) {
    const std::vector<double> held_out = numbers_in(multi, "held_out_q_mse");
    const auto chosen = multi.value("chosen", std::size_t{0});
    if (chosen < held_out.size())
      item("Held-out MSE", fmt::format("{} → {} rad²", html::number(held_out.front()),
                                       html::number(held_out[chosen])));
  }
  return text + "</dl>\n";
}

}  // namespace

std::string model_section(const Record& record) {
  if (record.fits.empty()) return {};
  std::string text = "<h2 id=\"models\">Models</h2>\n";
  for (std::size_t i = 0; i < record.fits.size(); ++i) {
    const FittedModel& fitted = record.fits[i];
    const bool first_seed = fitted.seed == fitted.model.seeds.front();
    const std::string seed =
        fitted.model.seeds.size() > 1 ? fmt::format(", seed {}", fitted.seed) : std::string();
    text += fmt::format("<section id=\"model-{0}-{1}\"><h3>{2}{3}</h3>\n",
                        html::escaped(fitted.model.name), fitted.seed, dotted(fitted.model), seed);
    if (fitted.file.is_null()) {
      text +=
          "<p class=\"note\">Known by its rollouts alone, made by another "
          "program.</p>\n</section>\n";
      continue;
    }
    text += health(fitted);
    text += "<details><summary>Parameters</summary>\n" + friction_tables(record, fitted) +
            body_table(record, fitted) + "</details>\n";
    const auto add_plot = [&](const char* kind, const char* title) {
      const std::string plot = plot_html(record, kind + fitted.model.name);
      if (!plot.empty())
        text += fmt::format("<details><summary>{}</summary>\n{}</details>\n", title, plot);
    };
    if (first_seed) {
      add_plot("torque_", "Torque along the measured motion");
      add_plot("correlation_", "Correlation of the parameters");
    }
    text += "</section>\n";
  }
  return text;
}

}  // namespace fricid::render
