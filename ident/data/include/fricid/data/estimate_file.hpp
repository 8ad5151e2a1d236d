// Estimates of the online filter along a log: the files estimates/....h5 of a run folder.
#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "fricid/base/field.hpp"
#include "fricid/signals/matrix.hpp"

namespace fricid::data {

/// Means and standard deviations at each of the T samples.
struct EstimateSignals {
  static constexpr std::string_view kFormat = "fricid.estimate/1";

  std::vector<std::string> joint_names;  ///< (n)
  std::string model, log;                ///< names
  Eigen::VectorXd t;                     ///< (T) [s]
  RowMatrix q, v, tau_f;                 ///< (T, n) [rad], [rad/s], [N m]
  RowMatrix z;                           ///< (T, state_size), or empty
  RowMatrix q_sd, v_sd, tau_f_sd, z_sd;  ///< of the same shapes
  Eigen::VectorXd log_likelihood, ess;   ///< (T) [nat], effective particles

  template <class Archive>
  void visit(Archive& archive) {
    archive.joints(joint_names);
    archive.stamp("model", model, text("name of the model"));
    archive.stamp("log", log, text("name of the log"));
    archive.times(t);
    archive.of_joints("q", q, signal("rad", "position, mean"));
    archive.of_joints("v", v, signal("rad/s", "velocity, mean"));
    archive.of_joints("tau_f", tau_f, signal("N m", "friction torque, mean"));
    archive.of_joints("q_sd", q_sd, signal("rad", "standard deviation of q"));
    archive.of_joints("v_sd", v_sd, signal("rad/s", "standard deviation of v"));
    archive.of_joints("tau_f_sd", tau_f_sd, signal("N m", "standard deviation of tau_f"));
    archive.of_states_or_none("z", z, signal("1", "states of the friction, mean"));
    archive.of_states_or_none("z_sd", z_sd, signal("1", "standard deviation of z"));
    archive.column("log_likelihood", log_likelihood, signal("1", "of the log up to here [nat]"));
    archive.column("ess", ess, signal("1", "effective number of particles"));
  }
};

}  // namespace fricid::data
