// Report of the trajectory design: the file excitation.json of a run folder.
#pragma once

#include <cmath>
#include <limits>
#include <span>
#include <string>
#include <vector>

#include "fricid/base/field.hpp"

namespace fricid::sim {

/// Margin to each limit over the whole trajectory; 1 for a limit that the robot does not have.
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
    const auto share = [](std::string_view meaning) { return at_most_one("1", meaning); };
    archive("joint", joint, text("name of the joint"));
    archive("position_rad", position_rad,
            any_number("rad", "distance to the nearer border of the position box"));
    archive("velocity", velocity, share("1 - largest speed / limit"));
    archive("acceleration", acceleration, share("1 - largest acceleration / limit"));
    archive("jerk", jerk, share("1 - largest jerk / limit"));
    archive("torque", torque, share("1 - largest torque, friction allowance included, / limit"));
  }
};

/// Design of one trajectory and its margins to the limits.
struct TrajectoryReport {
  std::string name;
  bool feasible = false;
  int evaluations = 0;       ///< of the criterion
  double log_det_start = 0;  ///< log det of the information matrix, best random start
  double log_det = 0;        ///< the same of the final trajectory
  double condition = 0;      ///< of the base regressor, rows weighted by 1 / effort
  double clearance_m = 0;    ///< smallest distance on the trajectory
  std::string closest;       ///< the two closest bodies
  std::vector<JointMargins> joints;

  template <class Archive>
  void visit(Archive& archive) {
    archive("name", name, text("name of the recording"));
    archive("feasible", feasible, flag("keeps all limits"));
    archive(
        "condition", condition,
        not_negative("1", "condition number of the base regressor, rows weighted by 1 / effort"));
    archive("log_det_start", log_det_start,
            any_number("1", "log det of the information, best random start"));
    archive("log_det", log_det, any_number("1", "log det of the information, final trajectory"));
    archive("evaluations", evaluations, number("", 0, 1e9, "evaluations of the criterion"));
    archive("clearance_m", clearance_m, any_number("m", "smallest distance on the trajectory"));
    archive("closest", closest, text("the two closest bodies"));
    archive.sections("margins", joints, "margins to the limits, joint by joint");
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

/// The least margin of a joint over all trajectories; NaN without trajectories of the joint.
inline double least_margin(std::span<const TrajectoryReport> trajectories, const std::string& joint,
                           double JointMargins::*margin) {
  double least = std::numeric_limits<double>::quiet_NaN();
  for (const TrajectoryReport& trajectory : trajectories)
    for (const JointMargins& own : trajectory.joints)
      if (own.joint == joint) least = std::fmin(least, own.*margin);
  return least;
}

}  // namespace fricid::sim
