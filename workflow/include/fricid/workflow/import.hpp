// Logs as the data sets that `fricid import` makes of them.
#pragma once

#include <filesystem>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "fricid/data/contract.hpp"
#include "fricid/data/dataset.hpp"
#include "fricid/data/diagnosis_file.hpp"
#include "fricid/doctor/finding.hpp"
#include "fricid/workflow/check.hpp"

namespace fricid::workflow {

/// A log and what the doctor says of it.
struct ImportedLog {
  data::Dataset data;                      ///< what is asked for mended
  std::vector<doctor::Finding> findings;   ///< of the log as it stands
  std::vector<doctor::FindingKind> fixed;  ///< kinds that are mended in this log
  /// What misleads in the mended log where something that does was mended: of several mistakes that
  /// hide each other one repair may make another.
  std::vector<doctor::Finding> left;
  std::vector<std::string> warnings;  ///< of `data::check_dataset`
  data::DiagnosisFile diagnosis;      ///< with what was mended

  bool is_repaired(const doctor::Finding& finding) const;
  /// Whether a fit to the repaired log would be wrong.
  bool misleads() const;
};

/// The logs of one campaign by their contract. Where there is a robot, their joints are in its
/// order, their torque has the timing that all of them together say (`settle_torque_timing`), and
/// the doctor knows its dynamics.
/// @param contract  read from `contract_file`, which messages name
/// @param fixes     kinds of findings to be mended, each in the logs that have one
/// @param say       takes lines about the reading
/// @throws UserError with the place in the file on a log that cannot be used or mended, or for a
///         kind that no log has
std::vector<ImportedLog> import_logs(std::span<const std::filesystem::path> logs,
                                     const data::Contract& contract,
                                     const std::filesystem::path& contract_file,
                                     const RobotOfLog& robot,
                                     std::span<const doctor::FindingKind> fixes,
                                     const std::function<void(const std::string&)>& say);

}  // namespace fricid::workflow
