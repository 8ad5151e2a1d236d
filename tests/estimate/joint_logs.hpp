// Logs of a small arm and what is known of it before a fit, for the tests of joint fits.
#pragma once

#include <cstdint>
#include <string_view>
#include <vector>

#include "arm_data.hpp"
#include "fricid/estimate/prepared.hpp"
#include "fricid/estimate/torque/joint_fit.hpp"

namespace fricid::estimate {

/// What two logs of an arm say before a fit.
inline Prepared prepared_of(const Arm& truth, const RigidBodyOptions& options,
                            LogOptions of_log = {}) {
  std::vector<data::Dataset> logs;
  for (const std::uint64_t seed : {1, 2}) {
    of_log.seed = seed;
    logs.push_back(make_log(truth, of_log));
  }
  return prepare(truth.robot, options, logs, 2);
}

/// A small arm whose friction grows with load and ripples, and what is known before a fit.
struct Logs {
  Arm truth;
  Prepared prepared;
  MultiStepOptions windows;

  Logs() {
    truth.robot = small_arm();
    const friction::JointSpec joint{{{"dahl", 0, {{"load", 1}, {"ripple", 1}}}}};
    truth.friction.model = friction::RobotFriction({joint, joint, joint});
    // Fc, sigma0, Fv, mu, n, A, phi
    for (const double size : {1.0, 0.8, 0.5})
      for (const double value : {6 * size, 3000 * size, 2 * size, 0.02, 100.0, 0.04, 0.7})
        truth.friction.theta.push_back(value);
    RigidBodyOptions options;
    options.min_speed_rad_s = 0.1;
    prepared = prepared_of(truth, options);
    windows.iterations = 20;
  }
};

inline const Logs& logs() {
  static const Logs made;
  return made;
}

inline double parameter(const Arm& arm, int joint, std::string_view owner,
                        std::string_view symbol) {
  const int at = friction::find_parameter(arm.friction.model, joint, owner, symbol);
  return arm.friction.theta.at(static_cast<std::size_t>(at));
}

/// The truth with other friction, as an arm of the same type has it.
inline Arm sibling(double factor) {
  Arm arm = logs().truth;
  arm.robot = logs().prepared.robot;
  for (int j = 0; j < 3; ++j) {
    const auto at = [&](std::string_view owner, std::string_view symbol) -> double& {
      const int p = friction::find_parameter(arm.friction.model, j, owner, symbol);
      return arm.friction.theta[static_cast<std::size_t>(p)];
    };
    at("dahl", "Fc") *= factor;
    at("dahl", "Fv") /= factor;
    at("ripple", "A1") = 0;
  }
  return arm;
}

/// The small arm with friction of one form. @param theta  of each joint
inline Arm arm_with(const friction::JointSpec& joint,
                    const std::vector<std::vector<double>>& theta) {
  Arm arm = logs().truth;
  arm.friction.model = friction::RobotFriction({joint, joint, joint});
  arm.friction.theta.clear();
  for (const std::vector<double>& of_joint : theta)
    arm.friction.theta.insert(arm.friction.theta.end(), of_joint.begin(), of_joint.end());
  return arm;
}

/// What its logs with noise say: without, fits that stop early have gains that no data could show.
inline Prepared noisy_logs(const Arm& truth, double seconds, bool repeats = false) {
  return prepared_of(
      truth, logs().prepared.options,
      {.seconds = seconds, .torque_noise = 0.05, .encoder_noise = 4e-6, .repeats = repeats});
}

}  // namespace fricid::estimate
