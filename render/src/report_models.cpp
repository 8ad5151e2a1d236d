#include <algorithm>
#include <cmath>

#include "fricid/evaluate/verdict.hpp"
#include "html.hpp"
#include "report_parts.hpp"

namespace fricid::render {
namespace {

using html::Cell;
using html::Row;
using html::Style;

/// A law of a joint, or a modifier of it.
struct Owner {
  std::string law, name;
  int size = 0;  ///< elements of the law, order of the modifier

  bool operator==(const Owner&) const = default;
  bool is_law() const { return name == law; }
};

/// Of the laws of all joints, each once.
std::vector<Owner> owners_of(const friction::RobotFriction& friction) {
  std::vector<Owner> owners;
  const auto add = [&](Owner owner) {
    if (std::ranges::find(owners, owner) == owners.end()) owners.push_back(std::move(owner));
  };
  for (const friction::JointSpec& joint : friction.joints())
    for (const friction::LawSpec& law : joint.laws) {
      add({law.law, law.law, law.elements});
      for (const friction::ModifierSpec& modifier : law.modifiers)
        add({law.law, modifier.name, modifier.order});
    }
  return owners;
}

/// Whether the law of a joint has the owner in that size.
bool has(const friction::LawSpec& law, const Owner& owner) {
  if (owner.is_law()) return law.elements == owner.size;
  return std::ranges::any_of(law.modifiers, [&](const friction::ModifierSpec& modifier) {
    return modifier.name == owner.name && modifier.order == owner.size;
  });
}

/// Index in theta of a parameter at a joint; -1: none.
/// @param of_any_size  also where the joint has more or fewer elements
int find_in(const friction::RobotFriction& friction, int joint, const Owner& owner,
            const std::string& symbol, bool of_any_size) {
  for (int i = friction.parameter_begin(joint); i < friction.parameter_begin(joint + 1); ++i) {
    const friction::ParameterRef& parameter = friction.parameters()[static_cast<std::size_t>(i)];
    const friction::LawSpec& law = friction.joints()[static_cast<std::size_t>(joint)]
                                       .laws[static_cast<std::size_t>(parameter.law)];
    if (law.law == owner.law && parameter.owner == owner.name && parameter.symbol == symbol &&
        (of_any_size || has(law, owner)))
      return i;
  }
  return -1;
}

/// The fit's record of a parameter of that joint.
struct Found {
  double value = kNaN, standard_error = kNaN;
  bool at_bound = false;
};

Found found_in(const FittedModel& fitted, int joint, const Owner& owner,
               const std::string& symbol) {
  const friction::Friction& friction = fitted.file->arm.friction;
  const int i = find_in(friction.model, joint, owner, symbol, false);
  if (i < 0) return {};
  Found found{.value = friction.theta[static_cast<std::size_t>(i)]};
  if (!fitted.fit || joint >= std::ssize(fitted.fit->joints)) return found;
  if (const auto* parameter = data::fitted_parameter(*fitted.fit, friction.model, i))
    found.standard_error = parameter->standard_error;
  const auto& at_bound = fitted.fit->joints[static_cast<std::size_t>(joint)].at_bound;
  found.at_bound = std::ranges::find(at_bound, symbol) != at_bound.end();
  return found;
}

double injected_at(const friction::Friction& truth, int joint, const Owner& owner,
                   const std::string& symbol) {
  const int i = find_in(truth.model, joint, owner, symbol, true);
  return i < 0 ? kNaN : truth.theta[static_cast<std::size_t>(i)];
}

Html interval(double lower, double upper) {
  return Html::of("{} … {}", html::number(lower), html::number(upper));
}

/// Parameters of one law or modifier as it appears at the joints: rows are symbols, columns joints.
Html owner_table(const Record& record, const FittedModel& fitted, const Owner& owner) {
  const Run& run = record.run;
  std::vector<Html> head = html::headings({"parameter"});
  for (int j = 0; j < run.n(); ++j) head.push_back(html::escaped(run.heading(j)));
  head.push_back(html::escaped("allowed"));

  int weights = 0;
  bool any_bound = false, any_truth = false, any_error = false;
  std::vector<Row> rows;
  for (const friction::ParameterInfo& info :
       owner.is_law() ? friction::parameters_of_law(owner.law, owner.size)
                      : friction::parameters_of_modifier(owner.name, owner.size)) {
    const std::string symbol(info.symbol);
    if (friction::is_weight(info.role)) {
      ++weights;
      continue;
    }
    Row row{{{Html::of("<span title=\"{}\">{}</span> <span class=\"soft\">{}</span>",
                       html::escaped(info.meaning), html::escaped(symbol),
                       info.has_unit() ? html::escaped(info.unit) : Html())}}};
    Row truth{{{Html::of("<span class=\"soft\">truth</span>")}}, Style::kSoft};
    bool has_truth = false;
    for (int j = 0; j < run.n(); ++j) {
      const Found found = found_in(fitted, j, owner, symbol);
      const double injected = run.truth ? injected_at(run.truth->friction, j, owner, symbol) : kNaN;
      Cell cell{html::number(found.value, 3)};
      if (std::isfinite(found.standard_error)) {
        cell.text += Html::of(" ± {}", html::number(found.standard_error, 1));
        any_error = true;
      }
      if (found.at_bound) {
        cell.text += Html::of("&#8239;†");
        cell.style = Style::kBad;
        any_bound = true;
      }
      row.cells.push_back(cell);
      truth.cells.push_back({html::number(injected, 3)});
      has_truth |= std::isfinite(injected);
    }
    row.cells.push_back({interval(info.lower, info.upper), Style::kSoft});
    truth.cells.emplace_back();
    rows.push_back(std::move(row));
    if (has_truth) rows.push_back(std::move(truth));
    any_truth |= has_truth;
  }
  if (rows.empty() && weights == 0) return {};
  Html caption = Html::of("Parameters of <i>{}</i>", html::escaped(owner.name));
  if (!owner.is_law()) caption += Html::of(" of <i>{}</i>", html::escaped(owner.law));
  if (owner.is_law() && owner.size > 0) caption += Html::of(", {} elements", owner.size);
  if (any_error) caption += Html::of("; ± standard error");
  if (any_bound) caption += Html::of("; † ended on its bound");
  if (any_truth) caption += Html::of("; truth: as injected");
  Html text = html::table(head, rows, Html::of("{}.", caption));
  if (weights > 0)
    text += Html::of("<p class=\"note\">And {} network weights per joint, in the model file.</p>\n",
                     weights);
  return text;
}

Html friction_tables(const Record& record, const FittedModel& fitted) {
  const friction::RobotFriction& friction = fitted.file->arm.friction.model;
  Html text;
  for (const Owner& owner : owners_of(friction)) text += owner_table(record, fitted, owner);
  if (friction.has_whole())
    text += Html::of(
        "<p class=\"note\">One <i>{}</i> for the whole robot, {} elements: {} weights and scales, "
        "in "
        "the model file.</p>\n",
        html::escaped(friction.whole().law), friction.whole().elements,
        friction.parameter_count() - friction.parameter_begin(friction.joint_count()));
  return text;
}

Html base_table(const std::vector<data::FittedBaseParameter>& base) {
  if (base.empty()) return {};
  std::vector<Row> rows;
  for (const data::FittedBaseParameter& parameter : base) {
    const double error = parameter.standard_error;
    rows.push_back({{{html::escaped(parameter.name), Style::kText},
                     {html::number(parameter.value, 4)},
                     {html::number(error, 2)},
                     {html::number(std::abs(error / parameter.value), 2)},
                     {html::number(parameter.physical, 4),
                      evaluate::is_moved_by_physics(parameter) ? Style::kBad : Style::kPlain}}});
  }
  return html::details(
      "Base parameters of the rigid body",
      html::table(
          html::headings({"combination", "estimate", "standard error", "relative", "physical"}),
          rows,
          Html::of("Base parameters [kg, kg m, kg m²]: what the data determine. Physical: those "
                   "of the nearest body with positive definite inertia, which the model uses; "
                   "marked where it lies more than three standard errors away.")));
}

Html body_table(const Record& record, const FittedModel& fitted) {
  const dynamics::RobotModel& robot = fitted.file->arm.robot;
  const data::FitFile fit = fitted.fit.value_or(data::FitFile());
  const data::FittedRigidBody& rigid = fit.rigid_body;
  std::vector<Html> head = html::headings({"joint"});
  for (int j = 0; j < record.run.n(); ++j) head.push_back(html::escaped(record.run.heading(j)));
  const Html unknown = Html::of("–");
  const auto titled = [](std::string_view title) { return Row{{{html::escaped(title)}}}; };
  Row mass = titled("mass [kg]"), armature = titled("armature [kg m²]"),
      rows_used = titled("rows used"), noise = titled("residual of the regression [N m]"),
      rms = titled("RMS of the torque residual [N m]"), r2 = titled("R²");
  for (int j = 0; j < robot.n(); ++j) {
    const auto at = static_cast<std::size_t>(j);
    mass.cells.push_back({html::number(robot.pi[10 * j], 3)});
    armature.cells.push_back({html::number(robot.pi[robot.armature_begin() + j], 3)});
    rows_used.cells.push_back(
        {at < rigid.rows.size() && at < rigid.rows_total.size()
             ? html::percent(static_cast<double>(rigid.rows[at]) / rigid.rows_total[at])
             : unknown});
    noise.cells.push_back({j < rigid.sigma.size() ? html::number(rigid.sigma[j]) : unknown});
    if (fit.joints.empty()) continue;
    rms.cells.push_back({html::number(fit.joints[at].residual_rms)});
    const double share = fit.joints[at].r2;
    r2.cells.push_back({std::isnan(share) ? unknown : Html::of("{:.4f}", share)});
  }
  std::vector<Row> rows{mass, armature, rows_used, noise};
  if (!fit.joints.empty()) rows.insert(rows.end(), {rms, r2});
  return html::table(
             head, rows,
             Html::of("Rigid body of the model, and statistics of its regression. Masses and "
                      "armatures alone are not determined by the data; the base "
                      "parameters are.")) +
         base_table(rigid.base);
}

Html health(const Record& record, const FittedModel& fitted) {
  if (!fitted.fit) return {};
  const data::FitFile& fit = *fitted.fit;
  Html text = Html::of("<dl>");
  const auto item = [&](std::string_view name, const Html& value) {
    if (!value.empty()) text += Html::of("<dt>{}</dt><dd>{}</dd>", html::escaped(name), value);
  };
  item("Method", html::escaped(fit.method));
  item("Outcome", html::escaped(name_of(fit.outcome)) +
                      (fit.usable ? Html() : Html::of(" <b class=\"bad\">not usable</b>")));
  item("In words",
       html::escaped(fit.prior_left_out ? fit.message + "; " + *fit.prior_left_out : fit.message));
  item("Fitted values", Html::of("{}", fit.parameters));
  if (fit.fitted_to) item("Fitted to", html::escaped(data::in_words(*fit.fitted_to)));
  if (const workflow::StageRecord* stage = record.manifest.find(workflow::stage_of(fitted.id)))
    item("Time", Html::of("{}&#8239;s", html::number(stage->seconds)));
  item("Condition of the regression", html::number(fit.rigid_body.condition));
  if (fit.em) {
    if (!fit.em->iterations.empty()) {
      const data::FittedIteration &first = fit.em->iterations.front(),
                                  &last = fit.em->iterations.back();
      item("Log-likelihood", Html::of("{} → {}", html::number(first.log_likelihood, 5),
                                      html::number(last.log_likelihood, 5)));
      item("NIS per channel",
           Html::of("{} (1: innovations as large as the model's noise)", html::number(last.nis)));
    }
    item("Held-out MSE", Html::of("{} rad² at the start", html::number(fit.em->held_out_start)));
  }
  if (fit.torque) item("Training on the torque", html::escaped(fit.torque->message));
  if (fit.multi_step && !fit.multi_step->held_out.empty()) {
    const std::vector<double>& held_out = fit.multi_step->held_out;
    item("Held-out MSE",
         Html::of("{} → {} rad²", html::number(held_out.front()),
                  html::number(held_out[static_cast<std::size_t>(fit.multi_step->chosen)])));
  }
  return text + Html::of("</dl>\n");
}

// The candidates that held-out data chose from, and the effect of each part of the sum of laws.
Html choice_tables(const data::FitFile& fit) {
  Html text;
  if (!fit.candidates.empty()) {
    std::vector<Row> rows;
    for (const data::FittedCandidate& c : fit.candidates)
      rows.push_back({{{html::escaped(c.name)},
                       {html::number(c.held_out)},
                       {html::number(c.torque)},
                       {Html::of("{}", c.parameters)},
                       {c.taken      ? Html::of("taken")
                        : c.eligible ? Html::of("eligible")
                                     : Html()}}});
    text += html::table(
        html::headings({"candidate", "rollouts [rad²]", "torque residual", "parameters", ""}), rows,
        Html::of(
            "Candidates. Eligible: held-out rollouts within a standard error of the best; taken: "
            "the least torque residual of these."));
  }
  if (!fit.parts.empty()) {
    std::vector<Row> rows;
    for (const data::FittedPart& p : fit.parts)
      rows.push_back({{{html::escaped(p.joint)},
                       {html::escaped(p.part)},
                       {html::number(p.gain)},
                       {html::number(p.error)},
                       {p.on ? Html::of("on") : Html::of("off")}}});
    text += html::table(
        html::headings({"joint", "part", "gain", "standard error", ""}), rows,
        Html::of("Parts of the sum of laws: the relative rise of the held-out mean square "
                 "of the torque without the part; on where it exceeds its standard error."));
  }
  if (text.empty()) return {};
  return html::details("Choice of parts", Html::of("\n") + text);
}

}  // namespace

Html model_section(const Record& record) {
  if (record.fits.empty()) return {};
  Html text = Html::of("<h2 id=\"models\">Models</h2>\n");
  for (std::size_t i = 0; i < record.fits.size(); ++i) {
    const FittedModel& fitted = record.fits[i];
    const bool first_seed = fitted.id == fitted.model.first_fit();
    const Html seed =
        fitted.model.seeds.size() > 1 ? Html::of(", seed {}", fitted.id.seed) : Html();
    text += Html::of("<section id=\"model-{0}-{1}\"><h3>{2}{3}</h3>\n",
                     html::escaped(fitted.model.name), fitted.id.seed, dotted(fitted.model), seed);
    if (!fitted.file) {
      text +=
          Html::of("<p class=\"note\">Only rollouts, made by another program.</p>\n</section>\n");
      continue;
    }
    text += health(record, fitted);
    text += html::details("Parameters", Html::of("\n") + friction_tables(record, fitted) +
                                            body_table(record, fitted));
    if (fitted.fit) text += choice_tables(*fitted.fit);
    const auto add_plot = [&](const char* kind, const char* title) {
      const Html plot = plot_html(record, kind + fitted.model.name);
      if (!plot.empty()) text += html::details(title, Html::of("\n") + plot);
    };
    if (first_seed) {
      add_plot("torque_", "Torque along the measured motion");
      add_plot("correlation_", "Correlation of the parameters");
    }
    text += Html::of("</section>\n");
  }
  return text;
}

}  // namespace fricid::render
