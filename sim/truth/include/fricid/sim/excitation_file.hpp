// How the trajectories of a scene were found: the file excitation.json of a run folder.
#pragma once

#include <string>
#include <vector>

#include "fricid/data/field.hpp"

namespace fricid::sim {

/// What is left of each limit on the whole trajectory; a limit that the robot does not state is 1.
/// Shares: 1 - largest value / allowed value.
struct JointMargins {
  std::string joint;
  double position_rad = 0;  ///< to the nearer border of the box [rad]
  double velocity = 0;
  double acceleration = 0;
  double jerk = 0;
  double torque = 0;  ///< rigid body plus the friction allowance

  template <class Archive>
  void visit(Archive& archive) {
    const auto share = [](std::string_view meaning) {
      return data::number("1", -1e300, 1, meaning);
    };
    archive("joint", joint, data::text("name of the joint"));
    archive("position_rad", position_rad,
            data::number("rad", -1e300, 1e300, "to the nearer border of the box"));
    archive("velocity", velocity, share("1 - largest speed / limit"));
    archive("acceleration", acceleration, share("1 - largest acceleration / limit"));
    archive("jerk", jerk, share("1 - largest jerk / limit"));
    archive("torque", torque, share("1 - largest torque, friction allowance included, / limit"));
  }
};

/// How one trajectory was found and how near its limits it comes.
struct TrajectoryReport {
  std::string name;
  bool feasible = false;
  int evaluations = 0;       ///< of the criterion
  double log_det_start = 0;  ///< log det of the information matrix, best random start
  double log_det = 0;        ///< the same, as kept
  double condition = 0;      ///< of the base regressor, rows weighted by 1 / effort
  double clearance_m = 0;    ///< smallest distance on the trajectory
  std::string closest;       ///< the two bodies that come that near
  std::vector<JointMargins> joints;

  template <class Archive>
  void visit(Archive& archive) {
    archive("name", name, data::text("of the recording"));
    archive("feasible", feasible, data::flag("keeps all limits"));
    archive("condition", condition,
            data::number("1", 0, 1e300, "of the base regressor, rows weighted by 1 / effort"));
    archive("log_det_start", log_det_start,
            data::number("1", -1e300, 1e300, "log det of the information, best random start"));
    archive("log_det", log_det, data::number("1", -1e300, 1e300, "the same, as kept"));
    archive("evaluations", evaluations, data::number("", 0, 1e9, "of the criterion"));
    archive("clearance_m", clearance_m,
            data::number("m", -1e300, 1e300, "smallest distance on the trajectory"));
    archive("closest", closest, data::text("the two bodies that come that near"));
    archive.sections("margins", joints, "what is left of the limits, joint by joint");
  }
};

struct ExcitationFile {
  static constexpr std::string_view kFormat = "fricid.excitation/1";

  std::vector<TrajectoryReport> trajectories;  ///< train, then validation

  template <class Archive>
  void visit(Archive& archive) {
    archive.sections("trajectories", trajectories, "training, then validation");
  }
};

}  // namespace fricid::sim
