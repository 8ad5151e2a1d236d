// The parts of `diagnose`; each appends what it found.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "fricid/doctor/finding.hpp"
#include "fricid/dynamics/robot_model.hpp"

namespace fricid::doctor {

using Findings = std::vector<Finding>;

/// restart: where another recording begins; or wrap: where a counter began again.
void check_restarts(const data::Dataset& d, Findings& findings);
/// out_of_order: rows up to a second behind later ones, between which their stamps leave room, and
/// by which the motion is smoother than by their places.
std::optional<Finding> find_out_of_order(const data::Dataset& d);
/// held: positions or torques that change at every m-th row alone. @pre one recording
std::optional<Finding> find_held(const data::Dataset& d);
/// in_turn: rows of two to four sources one after the other, of which each is smooth: most
/// positions leap from row to row by ten times what they move from a row of a source to its next.
/// @pre one recording
std::optional<Finding> find_sources_in_turn(const data::Dataset& d);
/// lost: steps of twice to six times those before and after, in all joints that move and at most
/// by chance one and a half times, while the time runs on evenly. It misleads where these are more
/// than one in a hundred. @pre even times
std::optional<Finding> find_lost_rows(const data::Dataset& d);
/// rate, gap, duplicate, jitter, clock_drift. @pre one recording
void check_clock(const data::Dataset& d, Findings& findings);
/// missing, stuck, same, constant, still, quantised, saturated, spike, jump, repeated,
/// temperature_unit and _trend.
void check_signals(const data::Dataset& d, Findings& findings);
/// Moving and holding.
void find_segments(const data::Dataset& d, Findings& findings);
/// velocity. @pre uniform times
void check_velocity(const data::Dataset& d, Findings& findings);
/// mount, sign, swapped, angle_unit, length_unit, torque_unit, delay, low_pass, delay_unknown.
/// @pre uniform times
void check_dynamics(const data::Dataset& d, const dynamics::RobotModel* robot, Findings& findings);

}  // namespace fricid::doctor
