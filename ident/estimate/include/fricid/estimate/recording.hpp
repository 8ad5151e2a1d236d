// A log as the gradient methods see it: motion at the samples and the torque held between them.
#pragma once

#include <span>
#include <vector>

#include "fricid/data/dataset.hpp"
#include "fricid/estimate/filter.hpp"
#include "fricid/system/arm.hpp"

namespace fricid::estimate {

/// One sequence of T samples of n joints.
struct Recording {
  std::string name;
  double dt = 0;                ///< [s]
  data::RowMatrix q, v;         ///< (T, n) zero-phase filtered motion, wide band
  data::RowMatrix q_measured;   ///< (T, n) as logged; NaN where missing
  data::RowMatrix tau;          ///< (T, n) held over [t_k, t_{k+1}); the last where missing
  data::RowMatrix temperature;  ///< (T, n) [K]
  Eigen::VectorXd noise_sd;     ///< (n) of q_measured, from what lies above the band [rad]

  int length() const { return static_cast<int>(q.rows()); }
  int n() const { return static_cast<int>(q.cols()); }
};

/// @pre `filtered` was made from `dataset` with this cut-off
Recording make_recording(const data::Dataset& dataset, const Filtered& filtered, double cutoff_hz);

/// Friction state of a model along every recording, washed out by the motion: (T, state_size) each,
/// from `initial_friction_state` on. Steps as `drive_friction` does, but in pieces of 4 s side by
/// side, each run in over the 4 s before it: what is older, the motion has made a joint forget. A
/// law of the whole robot is driven through each recording in one piece.
std::vector<data::RowMatrix> wash_out(const Arm& arm, std::span<const Recording> recordings,
                                      int jobs);

}  // namespace fricid::estimate
