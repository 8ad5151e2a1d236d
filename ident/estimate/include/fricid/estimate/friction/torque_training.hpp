// Training on the torque that the rigid body leaves, along the measured motion.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "fricid/estimate/friction/torque_windows.hpp"
#include "fricid/estimate/options/torque.hpp"
#include "fricid/estimate/report.hpp"
#include "fricid/optimise/descent.hpp"
#include "fricid/signals/recording.hpp"
#include "fricid/system/arm.hpp"

namespace fricid::estimate {

struct TorqueReport {
  Outcome outcome = Outcome::kFailed;
  std::string message = "train_torque was not called";
  Arm arm;  ///< best on the held-out part, the start included
  /// Held-out errors: mean over joints of residual / target mean square.
  optimise::DescentHistory history;
  double seconds = 0;
};

/// What friction has to explain when the rigid body is `arm`'s: the filtered torque less that of
/// the rigid body, along the motion that fits `filtered`. Refers to the recordings.
TorqueData torque_data(const Arm& arm, std::span<const signals::Recording> recordings,
                       bool filtered);

/// Minimises the error of the friction torque along windows of measured motion by Adam, over the
/// parameters of friction alone, by truncated back-propagation through its state; the states at the
/// windows' starts come from `wash_out`. Takes any friction of the tables. Returns the parameters
/// with the smallest error on the held-out part met on the way. Deterministic for a seed, whatever
/// `jobs`.
/// @throws UserError when a recording is too short for a window; Stopped on Ctrl-C
TorqueReport train_torque(const Arm& start, const TorqueData& data, const TorqueOptions& options,
                          std::string_view label, int jobs);

}  // namespace fricid::estimate
