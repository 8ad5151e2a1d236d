// A small arm and logs of it, made by the engine's own step at fine sub-steps.
#pragma once

#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "fricid/base/rng.hpp"
#include "fricid/data/dataset.hpp"
#include "fricid/dynamics/algorithms.hpp"
#include "fricid/dynamics/workspace.hpp"
#include "fricid/system/arm.hpp"

namespace fricid::estimate {

/// Three revolute joints (yaw, pitch, pitch) of a 6 kg, 3 kg, 1.5 kg arm with skew link inertias.
inline dynamics::RobotModel small_arm() {
  const auto link = [](const std::string& name, double m, double x, double z) {
    return "<link name='" + name + "'><inertial><origin xyz='" + std::to_string(x) + " 0.01 " +
           std::to_string(z) + "'/><mass value='" + std::to_string(m) +
           "'/><inertia ixx='0.030' iyy='0.045' izz='0.025' ixy='0.002' ixz='-0.003' "
           "iyz='0.001'/></inertial></link>";
  };
  const auto joint = [](const std::string& name, const std::string& parent,
                        const std::string& child, const std::string& xyz, const std::string& axis) {
    return "<joint name='" + name + "' type='revolute'><parent link='" + parent +
           "'/><child link='" + child + "'/><origin xyz='" + xyz + "'/><axis xyz='" + axis +
           "'/><limit lower='-3' upper='3' velocity='6' effort='150'/><fricid armature='0.1'/>"
           "</joint>";
  };
  return dynamics::parse_urdf("<robot name='small'><link name='base'/>" + link("l1", 6, 0.05, 0.1) +
                                  link("l2", 3, 0.15, -0.02) + link("l3", 1.5, 0.12, 0.03) +
                                  joint("j1", "base", "l1", "0 0 0.2", "0 0 1") +
                                  joint("j2", "l1", "l2", "0.1 0 0.2", "0 1 0") +
                                  joint("j3", "l2", "l3", "0.3 0 0", "0 1 0") + "</robot>",
                              "small_arm");
}

/// Friction of every joint by one law; theta repeats for each joint, torques scaled by 1, 0.8, 0.5.
inline friction::Friction same_law(const std::string& law, const std::vector<double>& theta, int n,
                                   int elements = 0) {
  friction::Friction out;
  out.model = friction::RobotFriction(std::vector<friction::JointSpec>(
      static_cast<std::size_t>(n), friction::JointSpec{{{law, elements, {}}}}));
  constexpr double kScale[] = {1, 0.8, 0.5};
  for (int j = 0; j < n; ++j)
    for (std::size_t i = 0; i < theta.size(); ++i) {
      const auto& unit = out.model.parameters()[i].info.unit;
      out.theta.push_back(theta[i] * (unit.starts_with("N m") ? kScale[j % 3] : 1.0));
    }
  return out;
}

/// The small arm with Coulomb and viscous friction. @param v0  smoothing speed [rad/s]
inline Arm coulomb_arm(double v0 = 1e-3) {
  Arm arm{small_arm(), {}};
  arm.friction = same_law("coulomb_viscous", {4, 2, v0}, arm.robot.n());
  return arm;
}

struct LogOptions {
  double seconds = 12;
  int substeps = 40;         ///< of the truth per 4 ms sample
  double peak_speed = 1.5;   ///< of the reference, about [rad/s]
  double torque_noise = 0;   ///< sd of the logged torque [N m]
  double encoder_noise = 0;  ///< sd of the logged position [rad]
  std::uint64_t seed = 1;
  int moving = -1;      ///< the only joint that moves; -1: all
  bool repeats = true;  ///< after 12 s; else frequencies have no common period
};

/// Tracks a random Fourier trajectory with held computed torque and logs q and tau.
inline data::Dataset make_log(const Arm& arm, const LogOptions& options) {
  const auto n = static_cast<std::size_t>(arm.robot.n());
  const double dt = 0.004, w = 2 * std::numbers::pi / 12;
  const int T = static_cast<int>(options.seconds / dt);
  constexpr int kHarmonics = 8;
  const auto frequency = [&](std::size_t harmonic) {
    const auto k = static_cast<double>(harmonic + 1);
    const double irrational = k * std::numbers::phi;
    return w * (options.repeats ? k : k + 0.5 * (irrational - std::floor(irrational)));
  };
  Rng rng(options.seed, 0), noise(options.seed, 1);
  std::vector<std::array<double, kHarmonics>> amplitude(n), phase(n);
  for (std::size_t j = 0; j < n; ++j)
    for (std::size_t k = 0; k < kHarmonics; ++k) {
      const bool moves = options.moving < 0 || options.moving == static_cast<int>(j);
      amplitude[j][k] = moves * options.peak_speed * rng.normal() / 4;  // of the velocity
      phase[j][k] = 2 * std::numbers::pi * rng.uniform();
    }

  data::Dataset log;
  log.name = "seed_" + std::to_string(options.seed);
  log.rate_hz = 1 / dt;
  for (const auto& joint : arm.robot.joints) log.joint_names.push_back(joint.name);
  log.t = Eigen::VectorXd::LinSpaced(T, 0, (T - 1) * dt);
  log.q.resize(T, arm.robot.n());
  log.tau.resize(T, arm.robot.n());

  ArmStepper<double> stepper(arm, {options.substeps});
  dynamics::Workspace<double> ws(arm.robot);
  std::vector<double> q(n), v(n), a(n), tau(n), reference(n), temperature(n, kRoomTemperature);
  std::vector<double> z(static_cast<std::size_t>(arm.friction.model.state_size()), 0.0);
  for (int k = 0; k < T; ++k) {
    for (std::size_t j = 0; j < n; ++j) {
      double qr = 0, vr = 0, ar = 0;
      for (std::size_t h = 0; h < kHarmonics; ++h) {
        const double wk = frequency(h), x = wk * log.t[k] + phase[j][h];
        qr += amplitude[j][h] / wk * std::sin(x);
        vr += amplitude[j][h] * std::cos(x);
        ar -= amplitude[j][h] * wk * std::sin(x);
      }
      if (k == 0) q[j] = qr, v[j] = vr;
      a[j] = ar + 400 * (qr - q[j]) + 40 * (vr - v[j]);
    }
    dynamics::rnea<double>(arm.robot, ws,
                           {arm.robot.pi.data(), static_cast<std::size_t>(arm.robot.pi.size())}, q,
                           v, a, tau);
    for (std::size_t j = 0; j < n; ++j) {
      const auto column = static_cast<Eigen::Index>(j);
      log.q(k, column) = q[j] + options.encoder_noise * noise.normal();
      log.tau(k, column) = tau[j] + options.torque_noise * noise.normal();
    }
    stepper.step(tau, temperature, dt, q, v, z);
  }
  return log;
}

}  // namespace fricid::estimate
