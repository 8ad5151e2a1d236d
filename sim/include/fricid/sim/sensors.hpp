#pragma once

#include <cstdint>

#include "fricid/base/rng.hpp"
#include "fricid/data/dataset.hpp"
#include "fricid/sim/options.hpp"
#include "fricid/sim/plant.hpp"

namespace fricid::sim {

/// Sensor model: the log of a trace. Per sample and joint
///
///     q_meas   = round_to(encoder_step, q + N(0, encoder_noise^2))
///     tau_meas = round_to(torque_step, tau delayed + N(0, torque_noise^2))
///     v_meas   = v + N(0, 2 (encoder_noise / dt)^2)                          if [sensors] velocity
///
/// with torque noise and step as shares of the effort limit. A dropped sample repeats the last one
/// that arrived. Every purpose, joint and sequence has a random stream of its own.
/// @param sequence  number of the recording within the run, unique over train and validation
data::Dataset measure(const Trace& trace, const SensorOptions& config,
                      const dynamics::RobotModel& robot, std::uint64_t seed, int sequence);

/// q_meas of a joint, with the next number of `noise`.
double encoder_reading(const SensorOptions& config, int joint, double q, Rng& noise);

/// tau_meas of the motor torques tau (T, n).
RowMatrix measured_torque(const RowMatrix& tau, const SensorOptions& config,
                          const dynamics::RobotModel& robot, std::uint64_t seed, int sequence);

/// Exponential warm-up over the whole campaign [K]: start + rise (1 - exp(-time / time constant)).
double temperature_at(const SensorOptions& config, double time);

}  // namespace fricid::sim
