#include "fricid/workflow/check.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <functional>
#include <numbers>
#include <ranges>
#include <utility>

#include "fricid/base/error.hpp"
#include "fricid/data/contract.hpp"
#include "fricid/data/log_part.hpp"
#include "fricid/data/training_part.hpp"
#include "fricid/doctor/doctor.hpp"
#include "fricid/dynamics/nominal.hpp"
#include "fricid/dynamics/rest_positions.hpp"
#include "fricid/estimate/prepared.hpp"
#include "fricid/scene/problem.hpp"
#include "fricid/scene/robot.hpp"
#include "fricid/sim/excitation.hpp"
#include "fricid/sim/mujoco_arm.hpp"
#include "fricid/workflow/recordings.hpp"
#include "fricid/workflow/run.hpp"
#include "fricid/workflow/run_folder.hpp"
#include "fricid/workflow/torque_timing.hpp"

namespace fricid::workflow {

namespace fs = std::filesystem;

namespace {

template <class Names>
[[noreturn]] void refuse_joint(const std::string& joint, const Names& allowed,
                               const std::string& where) {
  throw UserError("{}: joint {}; allowed: those that move in the robot's file, {}", where, joint,
                  fmt::join(allowed, " "));
}

}  // namespace

std::optional<dynamics::RobotModel> robot_of_log(
    const RobotOfLog& of_log, const std::vector<std::string>& logged, const std::string& where,
    const std::function<void(const std::string&)>& say,
    const std::vector<dynamics::NamedCoupling>& couplings) {
  const fs::path& urdf = of_log.urdf;
  const Eigen::Matrix3d mount = scene::mount_rotation(of_log.mount);
  if (urdf.empty()) return {};
  dynamics::Welds welds{dynamics::rest_positions(urdf)};
  for (const std::string& joint : logged)
    if (!welds.at.contains(joint)) refuse_joint(joint, std::views::keys(welds.at), where);
  for (const std::string& joint : logged) welds.at.erase(joint);
  std::vector<std::string> fixed;
  for (const auto& [joint, position] : welds.at)
    fixed.push_back(fmt::format("{} at {:.4g}", joint, position));
  dynamics::RobotModel robot = dynamics::load_urdf(urdf, mount, welds, of_log.mend_inertia);
  if (!fixed.empty() && say)
    say(fmt::format("{}: not logged, taken as fixed: {}", where, fmt::join(fixed, ", ")));
  robot.couplings = dynamics::couplings_of(couplings, robot.joint_names(), "coupling",
                                           [](std::string_view) { return "contract"; });
  dynamics::require_inertia(robot, urdf.string());
  return robot;
}

data::Contract of_robot(data::Contract contract, const dynamics::RobotModel& robot) {
  for (data::MotionColumns* motion : {&contract.position, &contract.velocity})
    for (const dynamics::Joint& joint : robot.joints) {
      const auto name = std::ranges::find(contract.joint_names, joint.name);
      const auto j = static_cast<std::size_t>(name - contract.joint_names.begin());
      if (motion->unit == "deg" && slides(joint) && j < motion->scale.size())
        motion->scale[j] *= 180 / std::numbers::pi;
    }
  return contract;
}

data::Dataset as_of_robot(const data::Dataset& log,
                          const std::optional<dynamics::RobotModel>& robot,
                          const std::string& where) {
  if (!robot) return log;
  const std::vector<std::string> joints = robot->joint_names();
  for (const std::string& joint : log.joint_names)
    if (std::ranges::count(joints, joint) == 0) refuse_joint(joint, joints, where);
  return data::of_joints(log, joints, {}, where);
}

data::Dataset joints_of(const data::Dataset& log, const dynamics::RobotModel& robot,
                        const std::string& whose, const std::string& where,
                        const std::map<std::string, double>& welds) {
  const std::vector<std::string> joints = robot.joint_names();
  const auto logged = [&](const std::string& joint) {
    return std::ranges::count(log.joint_names, joint) > 0;
  };
  const auto known = [&](const std::string& joint) {
    return std::ranges::count(joints, joint) > 0 || welds.contains(joint);
  };
  if (!std::ranges::all_of(joints, logged) || !std::ranges::all_of(log.joint_names, known))
    throw UserError("{}: {}found {}; allowed: those of {}, {}, in any order", where,
                    log.n() == robot.n()
                        ? std::string()
                        : fmt::format("{} joints, {} has {}: ", log.n(), whose, robot.n()),
                    fmt::join(log.joint_names, " "), whose, fmt::join(joints, " "));
  return data::of_joints(log, joints, welds, where);
}

Subject subject_of_run(const fs::path& folder) {
  const RunFolder run(folder);
  require_own_folder(run);
  const scene::Problem problem = scene::load_problem(run.scene());
  Subject subject{.sets = {},
                  .robot = problem.robot,
                  .identify = problem.scene.identify,
                  .excitation = problem.scene.excitation,
                  .mjcf = problem.mjcf_path};
  for (auto* name : {RunFolder::training, RunFolder::validation})
    for (data::Dataset& set : load_recordings(run, name, problem.scene.joints))
      subject.sets.push_back(std::move(set));
  if (subject.sets.empty())
    throw UserError("{}: found no data; run `fricid simulate` or `fricid run` first",
                    folder.string());
  return subject;
}

namespace {

using RobotOfJoints = std::function<std::optional<dynamics::RobotModel>(
    const std::vector<std::string>& joints, const std::string& where,
    const std::function<void(const std::string&)>& say,
    const std::vector<dynamics::NamedCoupling>& couplings)>;

Subject read_subject(const fs::path& of_log, const fs::path& contract, const RobotOfJoints& robot) {
  Subject subject;
  const data::LogPart part = data::log_part(of_log.string());
  const fs::path log = part.file;
  const auto in_part = [&](const data::Dataset& all) {
    return log == of_log ? all : data::cut(all, part, log.string());
  };
  const fs::path kind = log.extension();
  if (kind == ".toml")
    throw UserError(
        "{}: a TOML file; allowed: a run folder (`fricid simulate SCENE -o DIR` makes one), a data "
        "set, or a log with --contract FILE",
        log.string());
  if (contract.empty() && kind != ".h5" && kind != ".hdf5")
    throw UserError("{}: a log needs --contract FILE; `fricid template contract` prints one",
                    log.string());
  const auto say = [&](const std::string& line) { subject.warnings.push_back(line); };
  if (contract.empty()) {
    const data::Dataset read = in_part(data::load_dataset(log));
    subject.robot = robot(read.joint_names, log.string(), say, {});
    subject.sets.push_back(as_of_robot(read, subject.robot, log.string()));
  } else {
    data::Contract columns = data::load_contract(contract);
    subject.robot = robot(columns.joint_names, contract.string(), say, columns.couplings);
    if (subject.robot) columns = of_robot(std::move(columns), *subject.robot);
    const data::Dataset read = in_part(data::read_log(log, columns, say));
    subject.sets.push_back(as_of_robot(read, subject.robot, contract.string()));
    std::ranges::for_each(data::meaning_in_words(columns, contract.string()), say);
    if (subject.robot) settle_torque_timing(subject.sets, *subject.robot, columns.torque, say);
  }
  // no scene says what a slow log is filtered at
  double& cutoff_hz = subject.identify.cutoff_hz;
  if (const double rate_hz = subject.sets.front().rate_hz; 2 * cutoff_hz >= rate_hz && rate_hz > 0)
    cutoff_hz = rate_hz / 4;
  return subject;
}

}  // namespace

Subject subject_of_log(const fs::path& log, const fs::path& contract, const RobotOfLog& robot) {
  return read_subject(
      log, contract,
      [&](const std::vector<std::string>& joints, const std::string& where, const auto& say,
          const auto& couplings) { return robot_of_log(robot, joints, where, say, couplings); });
}

Subject subject_of_log(const fs::path& log, const fs::path& contract,
                       const std::optional<dynamics::RobotModel>& robot) {
  return read_subject(log, contract, [&](auto&&...) { return robot; });
}

namespace {

bool misleads(const std::vector<doctor::Finding>& findings) {
  return std::ranges::any_of(findings, [](const auto& f) { return doctor::misleads(f); });
}

}  // namespace

bool CheckReport::whole() const {
  if (parameters && !parameters->doubts.empty()) return false;
  return std::ranges::none_of(findings, [](const std::vector<doctor::Finding>& of_set) {
    return std::ranges::any_of(of_set, doctor::is_damage);
  });
}

std::vector<std::string> CheckReport::faults(const Subject& subject) const {
  std::vector<std::string> lines = doctor::to_lines(findings, subject.sets, doctor::is_damage);
  if (parameters)
    for (const std::string& doubt : parameters->doubts) lines.push_back(doubt);
  return lines;
}

std::vector<signals::Recording> recordings_of(const std::vector<data::Dataset>& sets,
                                              const Subject& subject) {
  for (const data::Dataset& d : sets) {
    data::check_dataset(d, d.name);
    if (d.joint_names != subject.sets.front().joint_names)
      throw UserError("{}: joints {}; allowed: those of {}, {}", d.name,
                      fmt::join(d.joint_names, " "), subject.sets.front().name,
                      fmt::join(subject.sets.front().joint_names, " "));
  }
  return estimate::recordings_of(*subject.robot, data::training_part(sets).recordings,
                                 subject.identify.cutoff_hz, 1);
}

CheckReport check(const Subject& subject) {
  CheckReport report;
  const dynamics::RobotModel* robot = subject.robot ? &*subject.robot : nullptr;
  report.findings = doctor::diagnose(subject.sets, robot);
  if (robot == nullptr) {
    report.not_examined = "no robot is named";
    return report;
  }
  std::vector<signals::Recording> recordings;
  try {
    recordings = recordings_of(subject.sets, subject);
  } catch (const UserError& error) {
    report.not_examined = error.what();
    return report;
  }
  estimate::IdentifiabilityOptions how;
  how.rigid_body = subject.identify;
  report.parameters = estimate::examine_data(*robot, recordings, how);
  // a wrong column contradicts the others, and has been named
  if (std::ranges::any_of(report.findings, misleads)) report.parameters->doubts.clear();
  return report;
}

NextMotion design_next(const Subject& subject, int jobs) {
  sim::ExcitationOptions one = subject.excitation;
  one.train = 1;
  one.validation = 0;
  const dynamics::RobotModel& robot = *subject.robot;
  const sim::MujocoArm arm(subject.mjcf, robot, 1e-3);
  const Eigen::MatrixXd known = estimate::base_information(
      robot, recordings_of(subject.sets, subject), subject.identify.cutoff_hz);
  const sim::Excitation next = sim::design_excitation(one, arm, robot, 1, jobs, known);
  return {.toml = sim::trajectory_toml(next.train[0], robot),
          .csv = sim::trajectory_csv(next.train[0], robot, subject.sets[0].rate_hz),
          .period_s = next.train[0].period(),
          .log_det_before = sim::log_det(sim::per_period(known, one)),
          .log_det_start = next.reports[0].log_det_start,
          .log_det = next.reports[0].log_det};
}

data::CheckFile check_file(const CheckReport& report, const Subject& subject) {
  data::CheckFile file;
  for (std::size_t i = 0; i < subject.sets.size(); ++i)
    file.doctor.push_back(doctor::diagnosis_file(report.findings[i], subject.sets[i]));
  if (report.parameters)
    file.identifiability = estimate::checked(*report.parameters, *subject.robot);
  return file;
}

}  // namespace fricid::workflow
