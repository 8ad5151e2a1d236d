#include "fricid/estimate/online/online_log.hpp"

#include <cmath>

#include <fmt/format.h>

#include "fricid/base/error.hpp"
#include "fricid/base/limits.hpp"
#include "fricid/base/progress.hpp"
#include "fricid/estimate/memory.hpp"
#include "fricid/system/transmission.hpp"
#include "missing.hpp"

namespace fricid::estimate {
namespace {

constexpr double kStartSpeed = 0.05;  // sd of the first velocity [rad/s]
constexpr double kStartPasses = 100;  // sd of the first z over sd of its noise per sample

LatentNoise noise_of(const data::ModelFile& model, Eigen::Index joints, double rate_hz,
                     std::string_view where) {
  if (!model.noise)
    throw UserError("model {}: noise is missing; allowed: a model written by fricid identify",
                    model.name);
  if (model.noise->friction.size() == 0)
    throw UserError(
        "model {}: noise.variance_friction is missing; allowed: a model written by this version's "
        "fricid identify",
        model.name);
  if (model.arm.robot.n() != joints)
    throw UserError("{}: {} joints, model {} has {}", where, joints, model.name,
                    model.arm.robot.n());
  if (!(std::abs(model.noise->dt * rate_hz - 1) <= 1e-6))
    throw UserError("{}: rate {} Hz; allowed for the noise of model {}: {} Hz", where, rate_hz,
                    model.name, 1 / model.noise->dt);
  LatentNoise noise = *model.noise;
  noise.R = noise.R.head(joints).eval();
  return noise;
}

void put(OnlineLog& out, int t, const OnlineEstimate& now) {
  out.q.row(t) = now.q;
  out.v.row(t) = now.v;
  out.z.row(t) = now.z;
  out.tau_f.row(t) = now.tau_f;
  out.q_sd.row(t) = now.q_sd;
  out.v_sd.row(t) = now.v_sd;
  out.z_sd.row(t) = now.z_sd;
  out.tau_f_sd.row(t) = now.tau_f_sd;
  out.log_likelihood[t] = now.log_likelihood;
  out.ess[t] = now.ess;
  out.lost += now.lost ? 1 : 0;
}

/// Errors of coupled motors count as independent.
void to_joints(const Transmission& motors, OnlineLog& out) {
  const Eigen::MatrixXd A = motors.A().cwiseAbs2(), C = motors.inverse().cwiseAbs2();
  out.q = motors.to_joints(out.q);
  out.v = motors.to_joints(out.v);
  out.tau_f = motors.torque_to_joints(out.tau_f);
  out.q_sd = (out.q_sd.cwiseAbs2() * A.transpose()).cwiseSqrt();
  out.v_sd = (out.v_sd.cwiseAbs2() * A.transpose()).cwiseSqrt();
  out.tau_f_sd = (out.tau_f_sd.cwiseAbs2() * C).cwiseSqrt();
}

}  // namespace

OnlineEstimator begin_online(const data::ModelFile& model, const LogStart& start, double rate_hz,
                             const OnlineOptions& options, std::string_view where) {
  const Eigen::Index n = start.q.size(), nz = model.arm.friction.model.state_size();
  const LatentNoise noise = noise_of(model, n, rate_hz, where);
  Eigen::VectorXd v = Eigen::VectorXd::Zero(n), z = Eigen::VectorXd::Zero(nz);
  if (start.v.size() > 0) v = start.v;
  if (!start.z.empty()) z = Eigen::Map<const Eigen::VectorXd>(start.z.data(), nz);
  return {model.arm, noise,
          online_start(start.q, v, z, noise, kStartSpeed, kStartPasses * noise.z.cwiseSqrt()),
          options};
}

OnlineLog estimate_log(const data::ModelFile& model, const data::Dataset& at_joints,
                       const OnlineOptions& options) {
  const Transmission motors(model.arm.robot);
  const data::Dataset log = motors.to_motors(at_joints);
  const int n = log.n(), nz = model.arm.friction.model.state_size(), T = log.length();
  require_memory(
      2 * memory_of_filter(options.particles, 2 * n + nz) + 8.0 * T * (2 * (3 * n + nz) + 3),
      log.name, fmt::format("the filter of {} particles", options.particles));
  RowMatrix tau = log.tau, q = log.q, temperature = log.temperature;
  hold_missing(tau, 0);
  hold_missing(q, 0);
  hold_missing(temperature, kRoomTemperature);
  OnlineEstimator estimator = begin_online(
      model, log_start(model.arm, log.dt(), q, tau, temperature), log.rate_hz, options, log.name);

  OnlineLog out;
  out.joint_names = log.joint_names;
  out.model = model.name;
  out.log = log.name;
  out.t = log.t;
  for (auto* x : {&out.q, &out.v, &out.tau_f, &out.q_sd, &out.v_sd, &out.tau_f_sd}) x->resize(T, n);
  for (auto* x : {&out.z, &out.z_sd}) x->resize(T, nz);
  out.log_likelihood.resize(T);
  out.ess.resize(T);
  put(out, 0, estimator.estimate());

  constexpr int kChunk = 100;
  Progress progress("estimate", T);
  const auto row = [n](const RowMatrix& x, int t) {
    return std::span<const double>(x.row(t).data(), static_cast<std::size_t>(n));
  };
  for (int t = 0; t + 1 < T; ++t) {
    throw_if_stopped();
    const auto temperature_now =
        temperature.size() > 0 ? row(temperature, t) : std::span<const double>();
    put(out, t + 1, estimator.step(row(tau, t), row(log.q, t + 1), temperature_now));
    if (t % kChunk == 0) progress.advance(kChunk, fmt::format("ESS {:.0f}", out.ess[t + 1]));
  }
  if (motors.coupled()) to_joints(motors, out);
  return out;
}

}  // namespace fricid::estimate
