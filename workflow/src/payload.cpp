#include "fricid/workflow/payload.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <utility>

#include "fricid/base/error.hpp"
#include "fricid/estimate/rigid_body/payload.hpp"

namespace fricid::workflow {
namespace {

const dynamics::Frame& frame_of(const dynamics::RobotModel& robot, const std::string& wanted) {
  const std::vector<std::string> names =
      wanted.empty() ? std::vector<std::string>{"flange", "tool0"} : std::vector{wanted};
  for (const std::string& name : names)
    if (const auto frame = std::ranges::find(robot.frames, name, &dynamics::Frame::name);
        frame != robot.frames.end())
      return *frame;
  std::vector<std::string> known;
  for (const dynamics::Frame& frame : robot.frames)
    if (frame.link >= 0) known.push_back(frame.name);
  throw UserError("--frame {}: no frame of {}; allowed: {}", fmt::join(names, " or "), robot.name,
                  fmt::join(known, " "));
}

std::vector<std::string> names_of(const std::vector<data::Dataset>& sets) {
  std::vector<std::string> names;
  for (const data::Dataset& d : sets) names.push_back(d.name);
  return names;
}

template <class Values>
std::vector<double> list(const Values& values) {
  return {values.begin(), values.end()};
}

// Ixx, Iyy, Izz, Ixy, Ixz, Iyz, as `payload_inertia` of a scene.
std::vector<double> six(const Eigen::Matrix3d& I) {
  return {I(0, 0), I(1, 1), I(2, 2), I(0, 1), I(0, 2), I(1, 2)};
}

}  // namespace

data::PayloadFile find_payload(const Subject& without, const std::vector<data::Dataset>& with,
                               const std::string& frame) {
  if (!without.robot)
    throw UserError("payload: needs a robot: --robot URDF, or the folder of a run");
  const dynamics::RobotModel& robot = *without.robot;
  const dynamics::Frame& carrier = frame_of(robot, frame);
  std::vector<data::Dataset> loaded;
  for (const data::Dataset& d : with) loaded.push_back(as_of_robot(d, robot, d.name));
  const estimate::PayloadFit fit =
      estimate::payload_least_squares(robot, carrier, recordings_of(without.sets, without),
                                      recordings_of(loaded, without), without.identify);
  const Subject with_load{loaded, without.robot, without.identify};
  CheckReport check_of_load = check(with_load);
  // the robot's file does not have the load: what it makes heavier is no wrong unit
  for (std::vector<doctor::Finding>& findings : check_of_load.findings)
    std::erase_if(findings, [](const doctor::Finding& finding) {
      return finding.kind == doctor::FindingKind::kTorqueUnit;
    });
  std::vector<std::string> doubts = check(without).faults(without);
  std::ranges::copy(check_of_load.faults(with_load), std::back_inserter(doubts));
  return {.without = names_of(without.sets),
          .with = names_of(with),
          .robot = robot.name,
          .frame = carrier.name,
          .outcome = fit.outcome,
          .message = fit.message,
          .doubts = std::move(doubts),
          .mass = fit.body.m,
          .mass_error = fit.body_error.m,
          .com = list(fit.body.c),
          .com_error = list(fit.body_error.c),
          .inertia = six(fit.body.I),
          .inertia_error = six(fit.body_error.I),
          .parameters = list(fit.pi),
          .free_parameters = list(fit.free),
          .parameter_errors = list(fit.standard_error)};
}

std::string to_text(const data::PayloadFile& p) {
  const auto numbers = [](const std::vector<double>& values) {
    std::vector<std::string> shown;
    for (const double x : values) shown.push_back(fmt::format("{:.4g}", x));
    return fmt::format("[{}]", fmt::join(shown, ", "));
  };
  const std::string outcome = fmt::format("# {}: {}\n", name_of(p.outcome), p.message);
  if (p.outcome == data::Outcome::kFailed) return outcome;
  return fmt::format(
      "{}[robot]\npayload_frame = \"{}\"\npayload_kg = {:.5g}  # +- {:.2g}\n"
      "payload_com = {}  # m, +- {}\npayload_inertia = {}  # kg m^2, +- {}\n",
      outcome, p.frame, p.mass, p.mass_error, numbers(p.com), numbers(p.com_error),
      numbers(p.inertia), numbers(p.inertia_error));
}

}  // namespace fricid::workflow
