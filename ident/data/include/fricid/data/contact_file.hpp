// External torque along a log: the result of `fricid contact`.
#pragma once

#include <Eigen/Core>
#include <string>
#include <string_view>
#include <vector>

#include "fricid/base/field.hpp"
#include "fricid/signals/matrix.hpp"

namespace fricid::data {

/// Estimates at each of the T samples.
struct ContactSignals {
  static constexpr std::string_view kFormat = "fricid.external_torque/1";

  std::vector<std::string> joint_names;  ///< (n)
  std::string model, log;                ///< names
  Eigen::VectorXd t;                     ///< (T) [s]
  RowMatrix tau_ext;                     ///< (T, n) [N m]; NaN: not known
  RowMatrix tau_f;                       ///< (T, n) friction of the model [N m]; NaN likewise

  template <class Archive>
  void visit(Archive& archive) {
    archive.joints(joint_names);
    archive.stamp("model", model, text("name of the model"));
    archive.stamp("log", log, text("name of the log"));
    archive.times(t);
    archive.of_joints("tau_ext", tau_ext,
                      signal("N m", "external torque; NaN where it is not known"));
    archive.of_joints("tau_f", tau_f, signal("N m", "friction torque of the model; NaN likewise"));
  }
};

}  // namespace fricid::data
