#include "fricid/workflow/import.hpp"

#include <algorithm>
#include <iterator>
#include <optional>
#include <utility>

#include "fricid/base/error.hpp"
#include "fricid/doctor/doctor.hpp"
#include "fricid/workflow/torque_timing.hpp"

namespace fricid::workflow {

namespace fs = std::filesystem;

namespace {

/// @return warnings @throws UserError with the place in the file on data that cannot be used
std::vector<std::string> judge(const data::Dataset& d, const fs::path& log,
                               const data::Contract& contract, bool as_it_was) {
  try {
    return data::check_dataset(d, log.string());
  } catch (const UserError&) {
    if (as_it_was) data::import_log(log, contract);  // throws with the place in the file
    throw;
  }
}

bool has(const std::vector<doctor::Finding>& findings, doctor::FindingKind kind) {
  return std::ranges::any_of(findings, [kind](const doctor::Finding& finding) {
    return finding.kind == kind && doctor::can_be_repaired(finding);
  });
}

}  // namespace

bool ImportedLog::is_repaired(const doctor::Finding& finding) const {
  return std::ranges::count(fixed, finding.kind) > 0 && doctor::can_be_repaired(finding);
}

bool ImportedLog::misleads() const {
  return !left.empty() || std::ranges::any_of(findings, [&](const doctor::Finding& finding) {
    return doctor::misleads(finding) && !is_repaired(finding);
  });
}

std::vector<ImportedLog> import_logs(std::span<const fs::path> logs, const data::Contract& contract,
                                     const fs::path& contract_file, const RobotOfLog& robot_of,
                                     std::span<const doctor::FindingKind> fixes,
                                     const std::function<void(const std::string&)>& say) {
  const std::optional<dynamics::RobotModel> robot =
      robot_of_log(robot_of, contract.joint_names, contract_file.string(), say, contract.couplings);
  const data::Contract columns = robot ? of_robot(contract, *robot) : contract;
  std::vector<data::Dataset> read;
  for (const fs::path& log : logs)
    read.push_back(as_of_robot(data::read_log(log, columns, say), robot, contract_file.string()));
  if (robot) settle_torque_timing(read, *robot, contract.torque, say);

  const std::vector<std::vector<doctor::Finding>> found =
      doctor::diagnose(read, robot ? &*robot : nullptr);
  std::vector<ImportedLog> imported;
  for (std::size_t i = 0; i < read.size(); ++i) {
    ImportedLog& log = imported.emplace_back();
    log.data = std::move(read[i]);
    log.findings = found[i];
    std::ranges::copy_if(fixes, std::back_inserter(log.fixed), [&](doctor::FindingKind kind) {
      return has(found[i], kind) || std::ranges::none_of(found, [kind](const auto& findings) {
               return has(findings, kind);
             });
    });
    try {
      log.data = doctor::repair(std::move(log.data), log.findings, log.fixed);
    } catch (const UserError& error) {
      throw UserError("{}: {}", logs[i].string(), error.what());
    }
    if (std::ranges::any_of(log.findings, [&](const doctor::Finding& finding) {
          return doctor::misleads(finding) && log.is_repaired(finding);
        })) {
      log.left = doctor::diagnose(log.data, robot ? &*robot : nullptr);
      std::erase_if(log.left,
                    [](const doctor::Finding& finding) { return !doctor::misleads(finding); });
    }
    log.diagnosis = doctor::diagnosis_file(log.findings, log.data);
    log.warnings = judge(log.data, logs[i], contract, fixes.empty());
  }
  return imported;
}

}  // namespace fricid::workflow
