#include <fmt/format.h>

#include "fricid/evaluate/warnings.hpp"
#include "html.hpp"
#include "report_parts.hpp"

namespace fricid::render {
namespace {

std::string name_of(const FittedModel& fitted) {
  return fitted.model.seeds.size() > 1
             ? fmt::format("{}, seed {}", fitted.model.label, fitted.id.seed)
             : fitted.model.label;
}

std::vector<evaluate::Warning> warnings_of(const Record& record) {
  std::vector<evaluate::Warning> warnings = evaluate::warnings_of(record.run.evaluation);
  for (const FittedModel& fitted : record.fits) {
    if (!fitted.fit) continue;
    const auto own =
        evaluate::warnings_of(*fitted.fit, name_of(fitted), record.run.measured.joint_names);
    warnings.insert(warnings.end(), own.begin(), own.end());
  }
  for (const sim::TrajectoryReport& trajectory : record.trajectories)
    if (!trajectory.feasible) warnings.push_back(evaluate::infeasible_excitation(trajectory.name));
  return warnings;
}

}  // namespace

Html warning_section(const Record& record) {
  const std::vector<evaluate::Warning> warnings = warnings_of(record);
  Html text = Html::of("<h2 id=\"warnings\">Warnings</h2>\n");
  if (warnings.empty()) return text + Html::of("<p>None.</p>\n");
  for (const evaluate::Warning& warning : warnings)
    text += Html::of(
        "<div class=\"warning\"><p><b>{}</b>: {}.</p><p class=\"note\">Meaning: {}. Remedy: "
        "{}.</p></div>\n",
        html::escaped(warning.subject), html::escaped(warning.found),
        html::escaped(warning.meaning), html::escaped(warning.remedy));
  return text;
}

}  // namespace fricid::render
