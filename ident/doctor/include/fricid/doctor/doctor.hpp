// The data doctor: finds faults of a log before it is used in a fit.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "fricid/data/dataset.hpp"
#include "fricid/doctor/finding.hpp"
#include "fricid/dynamics/robot_model.hpp"

namespace fricid::doctor {

/// Examines a log as it was read: times may have gaps, repeat or jitter.
///
/// Of rows that are out of order: out_of_order, then all others of the log sorted by time. Of the
/// times: rate, duplicate, wrap; gap, jitter, clock_drift, or uneven where the motion is
/// smooth by its stamps; of a file of several recordings
/// restart alone, and so of rows of several sources in turn. Of rows that are held: held, then all
/// others of the log without. Of each signal: missing, stuck, constant, unsigned, still, quantised,
/// saturated, spike, jump, repeated rows, lost ones. Between signals: columns of two joints that
/// are the same, a velocity that is not the derivative of the position. Against dynamics, by linear
/// regression of the torque on the motion under every hypothesis (a mount, a sign, a swap, degrees,
/// a delay): mount, no_gravity, sign, swapped, coupled, angle_unit, length_unit, torque_unit,
/// delay, low_pass, delay_unknown. With `robot` the regressors are its nominal torques, its limits
/// are checked (beyond_limit), and torque that stays at the effort of its joint is at_limit instead
/// of saturated; without it a wrong sign shows only as negative inertia or negative friction.
/// @return notes and damage, times first
/// @pre d.t, d.q, d.tau have equal lengths of at least 2; d.rate_hz is the usual rate
std::vector<Finding> diagnose(const data::Dataset& d, const dynamics::RobotModel* robot = nullptr);

/// The same of logs that are used together: a joint that moves in any of them is not still,
/// and a torque does not lead by more than the search where it does so in less than half of them.
/// @return of each log
std::vector<std::vector<Finding>> diagnose(std::span<const data::Dataset> logs,
                                           const dynamics::RobotModel* robot);

/// The kinds of these names. @throws UserError for one that is none or cannot be repaired
std::vector<FindingKind> fixes_of(std::span<const std::string> names);

/// Whether `repair` mends this: of jumps only those by whole turns.
bool can_be_repaired(const Finding& finding);

/// The log with the findings of some kinds repaired; `source` lists the repairs.
///
///     out_of_order the rows are sorted by time
///     wrap         the time goes on where its counter began again
///     held         the first row of each new value is kept, at the rate of the source
///     gap          rows of missing values where samples are lost
///     lost         the time runs on, with rows of missing values where rows are lost
///     duplicate    the later of two rows of equal time is dropped
///     jitter, clock_drift    times are replaced by uniform ones, but for gaps and duplicates
///     uneven       samples at even times are interpolated (`at_even_times`)
///     spike, repeated        the samples become missing values
///     jump         whole turns are removed from the position
///     sign, swapped, angle_unit    applied to the signals that the finding names
///     delay        torque is moved back in time, by linear interpolation
///     velocity, temperature_unit   the velocity is removed; 273.15 K are added
/// @throws UserError for a kind of which nothing that can be repaired was found (but for jitter,
///         which the reader may have evened out), and for a restart
/// @pre the kinds can be repaired
data::Dataset repair(data::Dataset d, std::span<const Finding> findings,
                     std::span<const FindingKind> kinds);

}  // namespace fricid::doctor
