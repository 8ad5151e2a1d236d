// Recordings whose motion is known without error.
#pragma once

#include <string>
#include <utility>

#include "fricid/signals/recording.hpp"

namespace fricid::test {

/// A log as a recording whose bands both are q and v themselves; the torque is as logged.
inline signals::Recording unfiltered(signals::Dataset log, const RowMatrix& v) {
  const Eigen::Index T = log.q.rows(), n = log.q.cols();
  signals::Recording out;
  out.dt = log.dt();
  out.narrow = out.wide = {log.q, v, {}};
  out.held_tau = out.filtered_tau = out.load = signals::held_torque(log.tau);
  out.temperature =
      log.temperature.size() > 0 ? log.temperature : RowMatrix::Constant(T, n, kRoomTemperature);
  out.use.setConstant(T, n, true);
  out.noise_sd = Eigen::VectorXd::Constant(n, 1e-6);
  out.step = Eigen::VectorXd::Zero(n);
  out.log = std::move(log);
  return out;
}

/// The same of signals alone, sampled at dt [s].
inline signals::Recording unfiltered(const std::string& name, double dt, const RowMatrix& q,
                                     const RowMatrix& v, const RowMatrix& tau) {
  signals::Dataset log;
  log.name = name;
  log.rate_hz = 1 / dt;
  log.t = Eigen::VectorXd::LinSpaced(q.rows(), 0, static_cast<double>(q.rows() - 1) * dt);
  log.q = q;
  log.tau = tau;
  return unfiltered(std::move(log), v);
}

}  // namespace fricid::test
