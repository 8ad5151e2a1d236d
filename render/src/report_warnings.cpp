#include <fmt/format.h>
#include <fmt/ranges.h>

#include <filesystem>

#include "fricid/base/enum_names.hpp"
#include "fricid/data/artefact.hpp"
#include "fricid/data/diagnosis_file.hpp"
#include "fricid/evaluate/warnings.hpp"
#include "fricid/workflow/recordings.hpp"
#include "html.hpp"
#include "report_parts.hpp"

namespace fricid::render {
namespace {

std::string name_of(const FittedModel& fitted) {
  return fitted.model.seeds.size() > 1
             ? fmt::format("{}, seed {}", fitted.model.label, fitted.id.seed)
             : fitted.model.label;
}

/// "saturated: tau, 0.6 to 46.3 s: -20 N m (4389 times)".
std::string in_words(const data::DiagnosedFinding& found) {
  return fmt::format("{}: {}, {:.3g} to {:.3g} s: {:.4g} {}{}", fricid::name_of(found.kind),
                     found.signal, found.begin_s, found.end_s, found.size, found.unit,
                     found.count > 1 ? fmt::format(" ({} times)", found.count) : "");
}

std::vector<evaluate::Warning> warnings_of(const Record& record) {
  std::vector<evaluate::Warning> warnings = evaluate::warnings_of(record.run.evaluation);
  for (const FittedModel& fitted : record.fits) {
    if (!fitted.fit) continue;
    const auto own =
        evaluate::warnings_of(*fitted.fit, name_of(fitted), record.run.measured.joint_names);
    warnings.insert(warnings.end(), own.begin(), own.end());
  }
  for (const auto set : {workflow::RunFolder::training, workflow::RunFolder::validation})
    for (int i = 0; std::filesystem::exists(record.run.folder.diagnosis(set(i))); ++i) {
      const auto file = data::load<data::DiagnosisFile>(record.run.folder.diagnosis(set(i)));
      for (const data::DiagnosedFinding& found : file.findings)
        if (found.severity == data::Severity::kDamage)
          warnings.push_back({fmt::format("{}{}{}", file.data, found.joints.empty() ? "" : ", ",
                                          fmt::join(found.joints, " and ")),
                              in_words(found), found.consequence, found.remedy});
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
