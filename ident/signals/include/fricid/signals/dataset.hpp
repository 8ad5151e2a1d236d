// A log: the measured signals, unfiltered.
#pragma once

#include <Eigen/Core>
#include <string>
#include <string_view>
#include <vector>

#include "fricid/base/field.hpp"
#include "fricid/signals/matrix.hpp"

namespace fricid {

/// Temperature used by friction laws if none was measured [K].
inline constexpr double kRoomTemperature = 293.15;

}  // namespace fricid

namespace fricid::signals {

/// The signals of a log, real or simulated: T samples of n joints. Row k is the sample at t_k;
/// tau_k is held over [t_k, t_{k+1}). Missing values are NaN.
struct Dataset {
  static constexpr std::string_view kFormat = "fricid.dataset/1";

  std::string name;                      ///< file stem, e.g. "train_0"
  std::vector<std::string> joint_names;  ///< (n)
  double rate_hz = 0;                    ///< nominal sample rate
  std::string source;                    ///< "simulation kr6_full seed 1", "import trajA_train.csv"
  Eigen::VectorXd t;                     ///< (T) [s], uniform
  RowMatrix q;                           ///< (T, n) [rad]
  RowMatrix tau;                         ///< (T, n) motor torque at the joint [N m]
  RowMatrix v;                           ///< (T, n) [rad/s] or empty
  RowMatrix temperature;                 ///< (T, n) [K] or empty
  /// Of what is not known of when a torque acts, standard deviation [s]: it may be measured at its
  /// sample, half a sample later than one that is held from it.
  double torque_delay_sd = 0;

  int length() const { return static_cast<int>(t.size()); }
  int n() const { return static_cast<int>(q.cols()); }
  double dt() const { return 1.0 / rate_hz; }

  /// All fields but the name, which is that of the file.
  template <class Archive>
  void visit(Archive& archive) {
    archive.joints(joint_names);
    archive.attribute("rate_hz", rate_hz, number("Hz", 0, 1e6, "nominal sample rate"));
    archive.attribute("source", source, text("where the samples come from"));
    archive.times(t);
    archive.of_joints("q", q, signal("rad", "position"));
    archive.of_joints("tau", tau,
                      signal("N m", "motor torque at the joint, held until the next sample"));
    archive.of_joints_or_none("v", v, signal("rad/s", "velocity"));
    archive.of_joints_or_none("temperature", temperature, signal("K", "of the joint"));
    archive.attribute_or_zero(
        "torque_delay_sd", torque_delay_sd,
        number("s", 0, 1, "of what is not known of when the torque acts; absent: 0"));
  }
};

}  // namespace fricid::signals
