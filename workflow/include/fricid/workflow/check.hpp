// Input and result of `fricid check`, and the motion to record next.
#pragma once

#include <filesystem>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "fricid/data/check_file.hpp"
#include "fricid/data/contract.hpp"
#include "fricid/data/dataset.hpp"
#include "fricid/doctor/finding.hpp"
#include "fricid/dynamics/robot_model.hpp"
#include "fricid/estimate/options/rigid_body.hpp"
#include "fricid/estimate/rigid_body/identifiability.hpp"
#include "fricid/signals/recording.hpp"
#include "fricid/sim/options.hpp"

namespace fricid::workflow {

struct Subject {
  std::vector<data::Dataset> sets;
  std::optional<dynamics::RobotModel> robot;  ///< none: parameters are not examined
  estimate::RigidBodyOptions identify{};
  sim::ExcitationOptions excitation{};
  std::filesystem::path mjcf{};         ///< absolute; empty: none
  std::vector<std::string> warnings{};  ///< of reading the data, one line each
};

/// The existing training and validation data of a run folder. @throws UserError
Subject subject_of_run(const std::filesystem::path& folder);
/// The robot of a log.
struct RobotOfLog {
  std::filesystem::path urdf;   ///< empty: none
  std::string mount = "floor";  ///< see `scene::mount_rotation`
  bool mend_inertia = false;    ///< see `dynamics::load_urdf`
};
/// A data set (HDF5), or a log by its contract; "FILE[FROM:TO]" is a part of it. @throws UserError
Subject subject_of_log(const std::filesystem::path& log, const std::filesystem::path& contract,
                       const RobotOfLog& robot);
/// Another log of a robot that is known, if it is.
Subject subject_of_log(const std::filesystem::path& log, const std::filesystem::path& contract,
                       const std::optional<dynamics::RobotModel>& robot);

/// The robot of a log with the joints `logged`: other moving joints of its file are taken as fixed,
/// at zero or at their limit nearest to it. Nothing for an empty path.
/// @param couplings  of the contract
/// @param say        takes a line about joints that are taken as fixed
/// @throws UserError naming `where` when a logged joint is none of the file
std::optional<dynamics::RobotModel> robot_of_log(
    const RobotOfLog& robot, const std::vector<std::string>& logged, const std::string& where,
    const std::function<void(const std::string&)>& say,
    const std::vector<dynamics::NamedCoupling>& couplings = {});

/// The contract as it is for the joints of a robot: degrees are those of joints that turn, what a
/// joint that slides has is in m.
data::Contract of_robot(data::Contract contract, const dynamics::RobotModel& robot);

/// The log with its joints in the order of the robot, if there is one.
/// @throws UserError naming `where` when they are others than those of the robot
data::Dataset as_of_robot(const data::Dataset& log,
                          const std::optional<dynamics::RobotModel>& robot,
                          const std::string& where);

/// Data sets as regressions take them: in motor coordinates, smoothed.
/// @pre subject.robot @throws UserError on data that cannot be used, or of other joints than those
/// of the subject
std::vector<signals::Recording> recordings_of(const std::vector<data::Dataset>& sets,
                                              const Subject& subject);

/// The log with the joints of the robot of a model or run, in their order, by name.
/// @param whose  "model lvm", for messages
/// @param welds  joints that are fixed: they may be logged, at their positions
/// @throws UserError naming `where` when the log lacks a joint or has another one
data::Dataset joints_of(const data::Dataset& log, const dynamics::RobotModel& robot,
                        const std::string& whose, const std::string& where,
                        const std::map<std::string, double>& welds = {});

struct CheckReport {
  std::vector<std::vector<doctor::Finding>> findings;  ///< one list per data set
  std::optional<estimate::Identifiability>
      parameters;            ///< empty without a robot or with faulty times
  std::string not_examined;  ///< why `parameters` is empty; else empty

  /// Whether no data set is damaged.
  bool whole() const;
  /// Damage and what contradicts in the data of the subject, one line each; none: it is whole.
  std::vector<std::string> faults(const Subject& subject) const;
};
CheckReport check(const Subject& subject);

/// A motion to record next, as a file and as samples.
struct NextMotion {
  std::string toml, csv;
  double period_s = 0;
  /// log det of the information on the base parameters: of the data alone, with the best random
  /// motion, and as designed; -infinity where it says nothing of one
  double log_det_before = 0, log_det_start = 0, log_det = 0;
};
/// The motion that, with the data of the subject, tells most about the base parameters.
/// @pre subject.robot @throws UserError
NextMotion design_next(const Subject& subject, int jobs);

/// The report as an artefact.
data::CheckFile check_file(const CheckReport& report, const Subject& subject);

}  // namespace fricid::workflow
