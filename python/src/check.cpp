// Faults of data, and the parameters that they identify.
#include "check.hpp"

#include <nanobind/stl/filesystem.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/tuple.h>

#include <tuple>

#include "fricid/data/artefact.hpp"
#include "fricid/workflow/check.hpp"
#include "job.hpp"

namespace fricid::python {
namespace {

namespace fs = std::filesystem;

/// Whether the data are undamaged, the report as JSON, the report as text.
using Report = std::tuple<bool, std::string, std::string>;

Report report_of(const workflow::Subject& subject) {
  const workflow::CheckReport report = workflow::check(subject);
  std::string words;
  for (const std::string& warning : subject.warnings) words += warning + "\n";
  for (const std::string& line : doctor::to_lines(report.findings, subject.sets))
    words += line + "\n";
  words += report.parameters
               ? estimate::to_summary(*report.parameters, *subject.robot, !report.whole())
               : "parameters: not examined: " + report.not_examined + "\n";
  return {report.whole(), data::to_json(workflow::check_file(report, subject)), words};
}

}  // namespace

void bind_check(nb::module_& m) {
  using nb::literals::operator""_a;
  m.def(
      "check_run",
      [](const fs::path& folder) {
        return job(nb::none(), [&] { return report_of(workflow::subject_of_run(folder)); });
      },
      "folder"_a);
  m.def(
      "check_file",
      [](const fs::path& log, const fs::path& contract, const fs::path& robot,
         const std::string& mount, bool mend_inertia) {
        return job(nb::none(), [&] {
          return report_of(workflow::subject_of_log(log, contract, {robot, mount, mend_inertia}));
        });
      },
      "log"_a, "contract"_a, "robot"_a, "mount"_a, "mend_inertia"_a);
  m.def(
      "check_log",
      [](const data::Dataset& log, const fs::path& robot, const std::string& mount,
         bool mend_inertia) {
        return job(nb::none(), [&] {
          workflow::Subject subject;
          subject.robot = workflow::robot_of_log(
              workflow::RobotOfLog{robot, mount, mend_inertia}, log.joint_names, log.name,
              [&](const std::string& line) { subject.warnings.push_back(line); });
          subject.sets.push_back(workflow::as_of_robot(log, subject.robot, log.name));
          return report_of(subject);
        });
      },
      "log"_a, "robot"_a, "mount"_a, "mend_inertia"_a);
}

}  // namespace fricid::python
