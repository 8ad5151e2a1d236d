// How well physics explains the torques of a log.
#pragma once

#include <optional>
#include <vector>

#include "fricid/dynamics/algorithms.hpp"
#include "fricid/system/transmission.hpp"
#include "sight.hpp"

namespace fricid::doctor {

/// Log of the factor by which the unexplained variances of all joints must fall, in sum, before a
/// hypothesis is believed; a nominal model is some 20 % wrong and keeps no wrong one below it.
inline constexpr double kBelief = 1.6;
/// Log of the factor by which one joint may become worse.
inline constexpr double kWorse = 0.4;

/// How well physics explains the torque of one joint.
struct Explained {
  double unexplained = 1;    ///< share of the variance
  double friction_only = 1;  ///< the same without the rigid body
  double scale = 0;          ///< measured over nominal torque; 0: does not count
  double rigid = 0;          ///< root mean square of the nominal torque times that [N m or N]
};

/// Judges a sight, with a robot or without.
class Judge {
 public:
  /// @param robot  nullptr: none is known; else it must outlive this
  Judge(const dynamics::RobotModel* robot, int n);

  /// Positive parts of the torque are friction, with a robot also its nominal torque, friction that
  /// grows with it and the armature of each motor of which the file states none. Without a robot
  /// inertia is, and gravity any sine of any joint.
  std::vector<Explained> explain(const Sight& s);

  /// Share of the torque of a joint that is unexplained if the centre of mass of its own link is
  /// free: that of a light link, a tool or a flange is often wrong in a file.
  double unexplained_with_centre(const Sight& s, int joint);

 private:
  /// Speeds and accelerations of the motors.
  struct Motors {
    data::RowMatrix v, a;
  };
  Motors motors_of(const Sight& s) const;
  Explained explain(const Sight& s, const data::RowMatrix& nominal, const Motors& motors, int j,
                    const data::RowMatrix& further) const;
  data::RowMatrix torques(const Sight& s, const dynamics::RobotModel& robot);
  /// (T, ..) What the robot's linear torques of joint j are per unit; constants apart.
  data::RowMatrix declared_torques(const Sight& s, int j) const;

  const dynamics::RobotModel* robot_;
  int n_;
  std::optional<dynamics::Workspace<double>> ws_;
  std::optional<Transmission> motors_;
};

/// Log of the factor by which the unexplained variances of all joints fall, in sum; -1 where one
/// joint becomes worse by more than `worse`, a log of a factor.
double gain(const std::vector<Explained>& before, const std::vector<Explained>& after,
            double worse = kWorse);

/// Log of the shares of all joints' variances that stay unexplained, in sum.
double log_unexplained(const std::vector<Explained>& explained);

}  // namespace fricid::doctor
