// Torque from outside: a push, a collision, a cable that catches.
#pragma once

#include <optional>
#include <span>
#include <string>

#include "fricid/dynamics/robot_model.hpp"
#include "fricid/estimate/disturbances.hpp"
#include "fricid/estimate/rigid_body/least_squares.hpp"
#include "fricid/signals/recording.hpp"

namespace fricid::estimate {

/// Looks for times in which what a fit leaves of a torque is far larger than at any other time:
/// what a model lacks comes back with every reversal, a hand comes a few times. Means of the
/// residual over .15 s make events, an event ending where they are below a quarter of its largest
/// for .3 s. Of a joint that reverses ten times at least, up to three events count that are six
/// times as large as the next one and exceed a twentieth of its torque, root mean square. The first
/// half second of a recording, which begins with bent springs, a joint that breaks away from rest
/// in all of its events, and one whose events all last from there on, as cables stay bent for
/// longer, say nothing.
/// @param residual     (T, n) of every recording [N m]
/// @param least_speed  (n) above which a joint slides [rad/s or m/s]
std::optional<Disturbances> find_disturbances(const dynamics::RobotModel& robot,
                                              std::span<const signals::Recording> recordings,
                                              std::span<const double> least_speed,
                                              const FrictionTorques& residual);

}  // namespace fricid::estimate
