// fricid import and fricid check: real logs, and faults of data.
#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <fstream>
#include <optional>

#include "commands.hpp"
#include "fricid/base/error.hpp"
#include "fricid/base/files.hpp"
#include "fricid/data/artefact.hpp"
#include "fricid/data/contract.hpp"
#include "fricid/doctor/doctor.hpp"
#include "fricid/estimate/rigid_body/identifiability.hpp"
#include "fricid/sim/excitation.hpp"
#include "fricid/workflow/check.hpp"
#include "fricid/workflow/import.hpp"
#include "fricid/workflow/run.hpp"
#include "outputs.hpp"
#include "terminal.hpp"

namespace fricid::cli {
namespace {

namespace fs = std::filesystem;

void print_lines(const std::vector<std::string>& lines, std::FILE* stream) {
  for (const std::string& line : lines) print(line + "\n", stream);
}

/// What was repaired is marked so and gets no remedy.
void print_findings(const workflow::ImportedLog& log, std::FILE* stream) {
  std::vector<doctor::Finding> left;
  for (const doctor::Finding& finding : log.findings) {
    if (!log.is_repaired(finding)) {
      left.push_back(finding);
      continue;
    }
    const std::string text = doctor::to_text(finding, log.data);
    print(fmt::format("{}: repaired{}\n", log.data.name,
                      text.substr(text.find(':'), text.find(';') - text.find(':'))),
          stream);
  }
  print_lines(doctor::to_lines({&left, 1}, {&log.data, 1}), stream);
  if (log.left.empty()) return;
  print(fmt::format("{}: the repaired log is damaged still; mend the contract by hand, one column "
                    "after the other:\n",
                    log.data.name),
        stream);
  print_lines(doctor::to_lines({&log.left, 1}, {&log.data, 1}), stream);
}

std::string path_of(const fs::path& log) { return fs::weakly_canonical(log).string(); }

/// @throws UserError when a data set is there that was not made of this log
void refuse_other_data(const fs::path& log, const fs::path& output) {
  if (!fs::exists(output)) return;
  const fs::path beside = workflow::RunFolder::diagnosis_beside(output);
  std::string made_of = "a file that `fricid import` did not make";
  if (fs::exists(beside)) {
    const auto diagnosis = data::load<data::DiagnosisFile>(beside);
    if (!diagnosis.log || *diagnosis.log == path_of(log)) return;
    made_of = "that of " + *diagnosis.log;
  }
  throw UserError(
      "{}: its data set would replace {}, {}; allowed: another folder with -o, or another name of "
      "the log",
      log.string(), output.string(), made_of);
}

/// Output files of the logs.
/// @throws UserError when two are the same file, or one is an input or made of another log
std::vector<fs::path> outputs_of(const ImportOptions& options) {
  std::vector<fs::path> paths, taken;
  for (const fs::path& input : options.logs) taken.push_back(fs::weakly_canonical(input));
  for (const fs::path& log : options.logs) {
    paths.push_back(options.output / log.filename().replace_extension(".h5"));
    const fs::path place = fs::weakly_canonical(paths.back());
    if (std::ranges::find(taken, place) != taken.end())
      throw UserError(
          "{}: its data set would go to {}, which is another log or its data set; "
          "name another folder with -o, or import the logs one by one",
          log.string(), paths.back().string());
    refuse_other_data(log, paths.back());
    taken.push_back(place);
  }
  return paths;
}

bool damaged(const std::vector<doctor::Finding>& findings) {
  return std::any_of(findings.begin(), findings.end(), doctor::is_damage);
}

void print_findings(const workflow::Subject& subject, const workflow::CheckReport& report,
                    bool verbose) {
  for (std::size_t i = 0; i < subject.sets.size(); ++i) {
    const data::Dataset& d = subject.sets[i];
    if (!damaged(report.findings[i]))
      print(fmt::format("{}: {:.4g} s at {:.4g} Hz: no damage found\n", d.name,
                        d.t[d.length() - 1] - d.t[0], d.rate_hz));
  }
  // all notes too if verbose
  print_lines(doctor::to_lines(report.findings, subject.sets, verbose ? nullptr : doctor::is_told),
              stdout);
}

}  // namespace

Verdict import_logs(const ImportOptions& options, const CommonOptions&) {
  const std::vector<doctor::FindingKind> fixes = doctor::fixes_of(options.fixes);
  const data::Contract contract = data::load_contract(options.contract);
  const auto warn = [](const std::string& warning) { print(warning + "\n", stderr); };
  const std::vector<fs::path> paths = outputs_of(options);
  const std::vector<workflow::ImportedLog> logs =
      workflow::import_logs(options.logs, contract, options.contract, options.robot, fixes, warn);
  for (const workflow::ImportedLog& log : logs) {
    print_findings(log, stderr);
    std::ranges::for_each(log.warnings, warn);
  }
  std::ranges::for_each(data::meaning_in_words(contract, printable(options.contract.string())),
                        warn);
  for (std::size_t i = 0; i < logs.size(); ++i) {
    data::DiagnosisFile diagnosis = logs[i].diagnosis;
    diagnosis.log = path_of(options.logs[i]);
    data::save(diagnosis, workflow::RunFolder::diagnosis_beside(paths[i]));
    data::save_dataset(logs[i].data, paths[i]);
    print(printable(paths[i].string()) + "\n");
  }
  return std::ranges::any_of(logs, &workflow::ImportedLog::misleads) ? Verdict::kNo
                                                                     : Verdict::kDone;
}

namespace {

workflow::Subject subject_of(const CheckOptions& options) {
  if (!workflow::is_run_folder(options.target))
    return workflow::subject_of_log(options.target, options.contract, options.robot);
  require_no_robot(options.robot, options.target);
  return workflow::subject_of_run(options.target);
}

void save_next_motion(const workflow::NextMotion& next, const fs::path& file) {
  const fs::path table = fs::path(file).replace_extension(".csv");
  write_file_atomically(file, next.toml);
  write_file_atomically(table, next.csv);
  print(fmt::format(
            "{} and {}: {:.3g} s of motion that, with what is there, raise the information on the "
            "base parameters: log det {:.4g} without it, {:.4g} with a random motion, {:.4g} as "
            "designed\n",
            printable(file.string()), printable(table.string()), next.period_s, next.log_det_before,
            next.log_det_start, next.log_det),
        stderr);
}

bool is_trajectory(const fs::path& file) {
  std::string head(1024, '\0');
  std::ifstream(file, std::ios::binary).read(head.data(), std::ssize(head));
  return head.find(sim::kTrajectoryFormat) != std::string::npos;
}

}  // namespace

/// @throws UserError when --design names an input or a file that is no trajectory, or the samples
/// would replace one
void require_design_name(const CheckOptions& options) {
  if (options.design.empty()) return;
  if (options.design.extension() != ".toml")
    throw UserError(
        "--design {}: allowed: a name that ends in .toml; the samples go to .csv beside",
        options.design.string());
  for (const char* extension : {".toml", ".csv"})
    require_not_input("--design", fs::path(options.design).replace_extension(extension),
                      {options.target, options.contract, options.robot.urdf});
  for (const char* extension : {".toml", ".csv"}) {
    const fs::path file = fs::path(options.design).replace_extension(extension);
    if (fs::exists(file) && !is_trajectory(options.design))
      throw UserError("--design {}: would replace {}; allowed: another name, or that of a design",
                      options.design.string(), file.string());
  }
}

Verdict check(const CheckOptions& options, const CommonOptions& common) {
  require_design_name(options);
  const workflow::Subject subject = subject_of(options);
  if (!subject.robot && !options.design.empty())
    throw UserError("--design: needs a robot: --robot URDF, or the folder of a run");
  for (const std::string& warning : subject.warnings) print(warning + "\n", stderr);
  const workflow::CheckReport report = workflow::check(subject);
  if (!common.json) print_findings(subject, report, options.verbose);
  if (!subject.robot) {
    print("parameters: not examined: --robot names no URDF\n", stderr);
  } else if (!report.parameters) {
    print(fmt::format("parameters: not examined: {}\n", report.not_examined), stderr);
  } else {
    if (!common.json) {
      if (const std::string_view warning = data::warning_of_torque(subject.sets.front());
          !warning.empty())
        print(fmt::format("torque: {}\n", warning));
      print(estimate::to_summary(*report.parameters, *subject.robot, !report.whole()));
      if (options.verbose) print(estimate::to_text(*report.parameters, *subject.robot));
    }
    if (!options.design.empty())
      save_next_motion(workflow::design_next(subject, common.jobs), options.design);
  }
  const data::CheckFile result = workflow::check_file(report, subject);
  if (common.json) print(visible_json(data::to_json(result)));
  if (workflow::is_run_folder(options.target))
    data::save(result, workflow::RunFolder(options.target).check());
  return report.whole() ? Verdict::kDone : Verdict::kNo;
}

}  // namespace fricid::cli
