// What the checks against dynamics see of a log, and what each of them looks for.
#pragma once

#include <vector>

#include "checks.hpp"
#include "local_fit.hpp"

namespace fricid::doctor {

/// Motion and torque of all joints at the chosen samples (S, n), and the rows at which each slides.
struct Sight {
  data::RowMatrix q, v, a, tau;
  std::vector<std::vector<int>> rows;
};

/// Half of the mean that averages out gear ripple, which a controller answers late [s].
inline constexpr double kSmoothing = 0.03;
/// Delays of the torque that are tried [s].
inline constexpr double kEarliest = -0.02, kLatest = 0.22;

/// Motors of a robot whose friction acts on joint j: turns per turn of the joint (0: none).
/// @param robot  nullptr: each joint has its own motor
Eigen::RowVectorXd motors_on(const dynamics::RobotModel* robot, int n, int j);

/// @param robot   nullptr: none is known
/// @param motion  local fits to the log
Sight see(const data::Dataset& d, const dynamics::RobotModel* robot, const Motion& motion);

/// Appends angle_unit where positions are in degrees, and takes them for radians in `sight`;
/// length_unit where a sliding joint is far outside its limits.
void undo_degrees(const data::Dataset& d, const dynamics::RobotModel* robot, const Motion& motion,
                  Sight& sight, Findings& findings);
/// Appends mount, where another direction of gravity explains far more; sign and swapped, one after
/// the other, each undone in `sight`; then torque_unit.
void undo_mistakes(const data::Dataset& d, const dynamics::RobotModel* robot, const Motion& motion,
                   Sight& sight, Findings& findings);
/// Appends delay, low_pass or delay_unknown: the delay of the torque at which regressions on rigid
/// body and friction of all joints explain most. It is reported where it also betters what
/// regressions explain of stretches that they were not fitted to, by more than the standard error
/// of that. A short log must gain more, since friction that lags gains by chance; of motion that
/// repeats one pass counts. Torque that also lacks what is fast went through a filter.
void check_delay(const data::Dataset& d, const dynamics::RobotModel& robot, const Motion& motion,
                 const Sight& sight, Findings& findings);

}  // namespace fricid::doctor
