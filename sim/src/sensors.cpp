#include "fricid/sim/sensors.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "fricid/sim/streams.hpp"

namespace fricid::sim {
namespace {

double round_to(double step, double value) {
  return step > 0 ? step * std::round(value / step) : value;
}

double at_or(double otherwise, const std::vector<double>& values, int joint) {
  return values.empty() ? otherwise : values[static_cast<std::size_t>(joint)];
}

// Replaces dropped rows by the last one that arrived; the first always arrives.
void drop_samples(data::Dataset& dataset, double share, Rng rng) {
  if (share <= 0) return;
  for (int k = 1; k < dataset.length(); ++k) {
    if (rng.uniform() >= share) continue;
    for (RowMatrix* matrix : {&dataset.q, &dataset.tau, &dataset.v, &dataset.temperature})
      if (matrix->rows() > 0) matrix->row(k) = matrix->row(k - 1);
  }
}

}  // namespace

double encoder_reading(const SensorOptions& config, int joint, double q, Rng& noise) {
  return round_to(at_or(0, config.encoder_step_rad, joint),
                  q + at_or(0, config.encoder_noise_rad, joint) * noise.normal());
}

RowMatrix measured_torque(const RowMatrix& tau, const SensorOptions& config,
                          const dynamics::RobotModel& robot, std::uint64_t seed, int sequence) {
  RowMatrix measured(tau.rows(), tau.cols());
  for (int j = 0; j < robot.n(); ++j) {
    const double effort = robot.joints[static_cast<std::size_t>(j)].effort;
    const double gain = at_or(1, config.torque_gain, j);
    Rng noise = make_rng(seed, Purpose::kTorque, sequence, j);
    for (Eigen::Index k = 0; k < tau.rows(); ++k) {
      const Eigen::Index delayed = std::max<Eigen::Index>(0, k - config.torque_delay_samples);
      measured(k, j) =
          round_to(config.torque_step * effort,
                   gain * tau(delayed, j) + config.torque_noise * effort * noise.normal());
    }
  }
  return measured;
}

double temperature_at(const SensorOptions& config, double time) {
  return config.temperature_start_K -
         config.temperature_rise_K * std::expm1(-time / config.temperature_time_s);
}

data::Dataset measure(const Trace& trace, const SensorOptions& config,
                      const dynamics::RobotModel& robot, std::uint64_t seed, int sequence) {
  const int T = trace.length(), n = robot.n();
  const double dt = 1 / config.rate_hz;
  data::Dataset dataset;
  dataset.joint_names = robot.joint_names();
  dataset.rate_hz = config.rate_hz;
  dataset.t = trace.t;
  dataset.q.resize(T, n);
  dataset.tau = measured_torque(trace.tau, config, robot, seed, sequence);
  if (config.velocity) dataset.v.resize(T, n);
  if (config.temperature) dataset.temperature = trace.temperature;

  for (int j = 0; j < n; ++j) {
    const double encoder_noise = at_or(0, config.encoder_noise_rad, j);
    Rng encoder = make_rng(seed, Purpose::kEncoder, sequence, j);
    Rng velocity = make_rng(seed, Purpose::kVelocity, sequence, j);
    for (int k = 0; k < T; ++k) {
      dataset.q(k, j) = encoder_reading(config, j, trace.q(k, j), encoder);
      if (config.velocity)
        dataset.v(k, j) =
            trace.v(k, j) + std::numbers::sqrt2 * encoder_noise / dt * velocity.normal();
    }
  }
  drop_samples(dataset, config.dropped, make_rng(seed, Purpose::kDrop, sequence, 0));
  return dataset;
}

}  // namespace fricid::sim
