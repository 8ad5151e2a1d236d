// Input and result of `fricid check`.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "fricid/data/check_file.hpp"
#include "fricid/data/dataset.hpp"
#include "fricid/doctor/finding.hpp"
#include "fricid/dynamics/robot_model.hpp"
#include "fricid/estimate/options/rigid_body.hpp"
#include "fricid/estimate/rigid_body/identifiability.hpp"
#include "fricid/scene/robot.hpp"
#include "fricid/sim/options.hpp"

namespace fricid::workflow {

struct Subject {
  std::vector<data::Dataset> sets;
  std::optional<dynamics::RobotModel> robot;  ///< none: parameters are not examined
  estimate::RigidBodyOptions identify{};
  sim::ExcitationOptions excitation{};
  std::filesystem::path mjcf{};  ///< absolute; empty: none
};

/// The existing training and validation data of a run folder. @throws UserError
Subject subject_of_run(const std::filesystem::path& folder);
/// The robot of a log.
struct RobotOfLog {
  std::filesystem::path urdf;  ///< empty: none
  scene::Mount mount = scene::Mount::kFloor;
};
/// A data set (HDF5), or a log by its contract. @throws UserError
Subject subject_of_log(const std::filesystem::path& log, const std::filesystem::path& contract,
                       const RobotOfLog& robot);

/// Nothing for an empty path. @throws UserError when its joints are not those of the log
std::optional<dynamics::RobotModel> robot_of_log(const RobotOfLog& robot,
                                                 const std::vector<std::string>& joints);

struct CheckReport {
  std::vector<std::vector<doctor::Finding>> findings;  ///< one list per data set
  std::optional<estimate::Identifiability>
      parameters;            ///< empty without a robot or with faulty times
  std::string not_examined;  ///< why `parameters` is empty; else empty

  /// Whether no data set is damaged.
  bool whole() const;
};
CheckReport check(const Subject& subject);

/// The report as an artefact.
data::CheckFile check_file(const CheckReport& report, const Subject& subject);

}  // namespace fricid::workflow
