// Signals of a simulated arm under control: the files loops/....h5 of a run folder.
#pragma once

#include <Eigen/Core>
#include <string>
#include <string_view>
#include <vector>

#include "fricid/base/field.hpp"
#include "fricid/signals/matrix.hpp"

namespace fricid::data {

/// The true arm along a desired motion. At every sample the motor torque is
/// tau = controller's + tau_forward, of which tau_feedback answers the errors.
struct LoopSignals {
  static constexpr std::string_view kFormat = "fricid.loop/1";

  std::vector<std::string> joint_names;  ///< (n)
  std::string model;                     ///< whose friction is fed forward; empty: none
  Eigen::VectorXd t;                     ///< (T) [s]
  RowMatrix q_desired, v_desired;        ///< (T, n) [rad], [rad/s]
  RowMatrix q, v;                        ///< (T, n) true [rad], [rad/s]
  RowMatrix tau;                         ///< (T, n) [N m]
  RowMatrix tau_feedback, tau_forward;   ///< (T, n) [N m]
  RowMatrix tau_f;                       ///< (T, n) true [N m]
  RowMatrix q_measured;                  ///< (T, n) what the encoders read [rad]
  RowMatrix tau_ext;                     ///< (T, n) of pushes, true; empty: none [N m]

  /// Keeps the first rows only.
  void keep(Eigen::Index rows) {
    t.conservativeResize(rows);
    for (RowMatrix* signal : {&q_desired, &v_desired, &q, &v, &tau, &tau_feedback, &tau_forward,
                              &tau_f, &q_measured, &tau_ext})
      if (signal->rows() > rows) signal->conservativeResize(rows, Eigen::NoChange);
  }

  template <class Archive>
  void visit(Archive& archive) {
    archive.joints(joint_names);
    archive.stamp("model", model, text("model whose friction is fed forward; empty: none"));
    archive.times(t);
    archive.of_joints("q_desired", q_desired, signal("rad", "desired position"));
    archive.of_joints("v_desired", v_desired, signal("rad/s", "desired velocity"));
    archive.of_joints("q", q, signal("rad", "true position"));
    archive.of_joints("v", v, signal("rad/s", "true velocity"));
    archive.of_joints("tau", tau, signal("N m", "motor torque applied"));
    archive.of_joints("tau_feedback", tau_feedback,
                      signal("N m", "part of tau that answers the errors"));
    archive.of_joints("tau_forward", tau_forward, signal("N m", "friction that was fed forward"));
    archive.of_joints("tau_f", tau_f, signal("N m", "true friction torque"));
    archive.of_joints("q_measured", q_measured, signal("rad", "position that the encoders read"));
    archive.of_joints_or_none("tau_ext", tau_ext, signal("N m", "true torque of pushes"));
  }
};

}  // namespace fricid::data
