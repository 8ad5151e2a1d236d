// Recordings drawn from the state-space model of an arm itself, noise and all: what a filter with
// that model must get right.
#pragma once

#include <Eigen/Cholesky>
#include <Eigen/LU>

#include "fricid/base/rng.hpp"
#include "fricid/estimate/em/em.hpp"
#include "fricid/estimate/em/latent_friction_model.hpp"
#include "kr6_truth.hpp"
#include "unfiltered.hpp"

namespace fricid::test {

inline constexpr double kEncoderNoise = 4e-6;  // [rad]
inline constexpr double kTorqueNoise = 0.005;  // share of Coulomb friction
inline constexpr double kLatentNoise = 0.002;  // share of the rms of z

/// A recording drawn from the model itself, with the states that made it.
struct Drawn {
  signals::Recording recording;
  LatentNoise noise;
  smc::Gaussian initial;
  RowMatrix x;      // (T, 2 n + n_z)
  RowMatrix tau_f;  // (T, n)
};

inline std::span<const double> view(const Eigen::VectorXd& x) {
  return {x.data(), static_cast<std::size_t>(x.size())};
}

/// Follows a motion by PD and inverse dynamics on the true state, noise as the model has it.
inline Drawn draw(const Arm& arm, int T, std::uint64_t seed, StepOptions step) {
  const HangingMotion motion(seed);
  const auto clean = record(arm, motion, T, step);
  const int n = arm.robot.n(), nz = arm.friction.model.state_size();
  Drawn out;
  out.recording = unfiltered("drawn", kSamplePeriod, clean.q, clean.v, clean.tau);
  out.recording.noise_sd.setConstant(kEncoderNoise);
  const std::vector<RowMatrix> z{clean.z};
  const Eigen::VectorXd z_size = estimate::latent_sizes(z);

  dynamics::Workspace<double> ws(arm.robot);
  Eigen::MatrixXd M(n, n);
  dynamics::crba<double>(arm.robot, ws, view(arm.robot.pi),
                         {clean.q.row(0).data(), static_cast<std::size_t>(n)},
                         {M.data(), static_cast<std::size_t>(n * n)});
  Eigen::VectorXd friction(n);
  for (int j = 0; j < n; ++j)
    friction[j] = kTorqueNoise * kJointScales[static_cast<std::size_t>(j)].Fc;
  const Eigen::VectorXd mobility = kSamplePeriod * M.inverse().diagonal();
  out.noise.dt = kSamplePeriod;
  out.noise.R = Eigen::VectorXd::Constant(n, kEncoderNoise * kEncoderNoise);
  out.noise.q = 0.25 * 0.25 * out.noise.R;
  out.noise.v = friction.cwiseProduct(mobility).cwiseAbs2();
  out.noise.z = (kLatentNoise * z_size).cwiseAbs2();
  out.initial = estimate::initial_state(out.recording, clean.z.row(0), z_size, out.noise);

  estimate::LatentFrictionModel model(arm, out.recording, out.noise, out.initial, step);
  const Eigen::MatrixXd L = model.Q().llt().matrixL();
  out.x.resize(T, 2 * n + nz);
  out.tau_f.resize(T, n);
  Rng rng(seed, 77);
  const auto size = static_cast<std::size_t>(n);
  Eigen::VectorXd x = out.initial.mean, e(x.size());
  std::vector<double> a(size), tau(size), tau_f(size);
  for (int t = 0; t < T; ++t) {
    for (int j = 0; j < n; ++j) {
      const auto wanted = motion.at(j, t * kSamplePeriod);
      a[static_cast<std::size_t>(j)] =
          wanted.a + 2500 * (wanted.q - x[j]) + 90 * (wanted.v - x[n + j]);
      out.recording.log.q(t, j) = x[j] + kEncoderNoise * rng.normal();
    }
    dynamics::rnea<double>(arm.robot, ws, view(arm.robot.pi), {x.data(), size},
                           {x.data() + n, size}, a, tau);
    std::copy(tau.begin(), tau.end(), out.recording.held_tau.row(t).data());
    const auto state = static_cast<std::size_t>(x.size());
    model.friction_torque<double>(t, std::span<const double>(x.data(), state), tau_f);
    out.x.row(t) = x;
    std::copy(tau_f.begin(), tau_f.end(), out.tau_f.row(t).data());
    model.transition<double>(t, {x.data(), state});
    for (double& value : e) value = rng.normal();
    x += L * e;
  }
  return out;
}

}  // namespace fricid::test
