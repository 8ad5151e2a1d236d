#pragma once

#include <Eigen/Core>
#include <vector>

#include "fricid/data/dataset.hpp"

namespace fricid::sim {

using data::RowMatrix;

/// State of the true arm.
struct State {
  std::vector<double> q;  ///< (n) [rad]
  std::vector<double> v;  ///< (n) [rad/s]
  std::vector<double> z;  ///< (state_size) friction state
};

/// Trajectory of the true arm. Row k holds the state at t_k, and acceleration and
/// friction torque there under tau_k, the motor torque applied over [t_k, t_{k+1}).
struct Trace {
  Eigen::VectorXd t;      ///< (T) [s]
  RowMatrix q, v, a;      ///< (T, n) [rad], [rad/s], [rad/s^2]
  RowMatrix tau, tau_f;   ///< (T, n) [N m]
  RowMatrix z;            ///< (T, state_size)
  RowMatrix temperature;  ///< (T, n) [K]

  int length() const { return static_cast<int>(t.size()); }
  State state(int sample) const;
};

/// Empty trace of `length` samples with dt between them.
Trace make_trace(int length, double dt, int n, int state_size);

}  // namespace fricid::sim
