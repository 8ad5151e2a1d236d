// Fits to logs of the small arm with default options, and what is said of them.
#pragma once

#include <string>
#include <vector>

#include "arm_data.hpp"
#include "fricid/estimate/fit.hpp"

namespace fricid::estimate {

inline ModelOptions model_of_one_start(const std::string& name) {
  ModelOptions config;
  config.name = name;
  config.starts = 1;
  return config;
}

/// The fit of a law with default options.
inline FitReport fit(const dynamics::RobotModel& robot, const std::vector<data::Dataset>& logs,
                     const std::string& law = "simple") {
  return fit_conventional(prepare(robot, {}, logs, 2), model_of_one_start(law), 1, 2);
}

/// All faults, a line each.
inline std::string text_of(const std::vector<Fault>& faults) {
  std::string text;
  for (const Fault& f : faults) text += f.joint + ": " + f.found + "; " + f.remedy + "\n";
  return text;
}

/// The robot as its maker publishes it: no armature, the last link a point.
inline dynamics::RobotModel as_published(dynamics::RobotModel robot) {
  robot.pi.segment(robot.armature_begin(), robot.n()).setZero();
  auto last = robot.pi.segment<10>(10 * (robot.n() - 1));
  const double m = last[0];
  const Eigen::Vector3d c = last.segment<3>(1) / m;
  last.setZero();
  dynamics::add_payload(robot, {.name = "", .link = robot.n() - 1}, m, c, Eigen::Matrix3d::Zero());
  return robot;
}

inline Arm lugre_arm() {
  Arm arm{small_arm(), {}};
  arm.friction = same_law("lugre", {4, 4.4, 0.05, 8000, 40, 2}, arm.robot.n());
  return arm;
}

/// A log of noisy torque.
inline data::Dataset noisy_log(const Arm& arm) {
  LogOptions options;
  options.torque_noise = 0.3;
  return make_log(arm, options);
}

}  // namespace fricid::estimate
