// fricid import and fricid check: real logs, and what is wrong with data.
#include <fmt/format.h>

#include <cstdio>
#include <nlohmann/json.hpp>
#include <optional>

#include "commands.hpp"
#include "fricid/base/error.hpp"
#include "fricid/base/files.hpp"
#include "fricid/data/contract.hpp"
#include "fricid/data/experiment.hpp"
#include "fricid/doctor/doctor.hpp"

namespace fricid::cli {
namespace {

namespace fs = std::filesystem;

/// The robot of a URDF, standing on the floor; nothing when none is named.
/// @throws UserError when its joints are not those of the log
std::optional<dynamics::RobotModel> load_robot(const fs::path& urdf,
                                               const std::vector<std::string>& joints) {
  if (urdf.empty()) return {};
  dynamics::RobotModel robot = dynamics::load_urdf(urdf);
  std::vector<std::string> names;
  for (const dynamics::Joint& joint : robot.joints) names.push_back(joint.name);
  if (names != joints)
    throw UserError("{}: joints {}; allowed: those of the log, {}", urdf.string(),
                    fmt::join(names, " "), fmt::join(joints, " "));
  return robot;
}

const dynamics::RobotModel* pointer(const std::optional<dynamics::RobotModel>& robot) {
  return robot ? &*robot : nullptr;
}

void print_findings(const std::vector<doctor::Finding>& findings, const data::Dataset& d,
                    std::FILE* stream) {
  for (const doctor::Finding& finding : findings)
    fmt::print(stream, "{}: {}\n", d.name, doctor::to_text(finding, d));
}

bool damaged(const std::vector<doctor::Finding>& findings) {
  return std::any_of(findings.begin(), findings.end(), doctor::is_damage);
}

}  // namespace

Verdict import_logs(const ImportOptions& options, const CommonOptions&) {
  const data::Contract contract = data::load_contract(options.contract);
  const auto robot = load_robot(options.robot, contract.joint_names);
  std::vector<data::Dataset> sets;
  std::vector<std::string> reports;
  for (const fs::path& log : options.logs) {
    const data::Dataset read = data::read_log(log, contract);
    const auto findings = doctor::diagnose(read, pointer(robot));
    print_findings(findings, read, stderr);
    sets.push_back(doctor::repair(read, findings, options.fixes));
    reports.push_back(doctor::to_json(findings, sets.back()));
    data::check_dataset(sets.back(), log.string());
  }
  for (std::size_t i = 0; i < sets.size(); ++i) {
    fs::path path = options.output / options.logs[i].filename().replace_extension(".h5");
    data::save_dataset(sets[i], path);
    write_file_atomically(fs::path(path).replace_extension(".doctor.json"), reports[i]);
    std::printf("%s\n", path.c_str());
  }
  return Verdict::kDone;
}

Verdict check(const CheckOptions& options, const CommonOptions& common) {
  std::vector<data::Dataset> sets;
  std::optional<dynamics::RobotModel> robot;
  if (fs::exists(options.target / "manifest.json")) {
    robot = data::load_experiment(options.target / "scene.toml").model;
    for (const char* kind : {"train", "validation"})
      for (int i = 0;; ++i) {
        const fs::path file = options.target / "data" / fmt::format("{}_{}.h5", kind, i);
        if (!fs::exists(file)) break;
        sets.push_back(data::load_dataset(file));
      }
    if (sets.empty())
      throw UserError("{}: found no data; run `fricid simulate` or `fricid run` first",
                      options.target.string());
  } else if (options.contract.empty()) {
    sets.push_back(data::load_dataset(options.target));
  } else {
    sets.push_back(data::read_log(options.target, data::load_contract(options.contract)));
  }
  if (!robot) robot = load_robot(options.robot, sets[0].joint_names);

  bool whole = true;
  nlohmann::ordered_json reports = nlohmann::ordered_json::array();
  for (const data::Dataset& d : sets) {
    const auto findings = doctor::diagnose(d, pointer(robot));
    whole = whole && !damaged(findings);
    if (common.json)
      reports.push_back(nlohmann::ordered_json::parse(doctor::to_json(findings, d)));
    else
      print_findings(findings, d, stdout);
  }
  if (common.json) std::printf("%s\n", reports.dump(2).c_str());
  return whole ? Verdict::kDone : Verdict::kNo;
}

}  // namespace fricid::cli
