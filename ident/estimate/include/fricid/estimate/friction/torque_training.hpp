// Stage S1: training on the torque that the rigid body leaves, along the measured motion.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "fricid/estimate/filter.hpp"
#include "fricid/estimate/friction/torque_windows.hpp"
#include "fricid/estimate/report.hpp"
#include "fricid/system/arm.hpp"

namespace fricid::estimate {

struct TorqueOptions {
  double window_s = 0.5;  ///< over which the friction state is differentiated, at least a sample
  int batch = 32;         ///< windows per iteration
  int iterations = 2000;
  double rate = 4e-3;     ///< of Adam, times 0.3 after 60 % and 0.1 after 85 % of the iterations
  bool filtered = true;   ///< the model's torque passes the filter of the measured one; else motion
                          ///< and torque are both compared as filtered at the cut-off
  double hold_out = 0.2;  ///< share of every recording
  int wash_out_every = 100;  ///< iterations between refreshes of the friction states
  int checks = 20;           ///< how often the held-out error is looked at
  double cutoff_hz = 10;     ///< of the measured torque's filter
  std::uint64_t seed = 1;
};

struct TorqueReport {
  Outcome outcome = Outcome::kFailed;
  std::string message = "train_torque was not called";
  Arm arm;                       ///< best on the held-out part, the start included
  std::vector<double> loss;      ///< per iteration, mean over the batch
  std::vector<int> checked;      ///< iterations after which the held-out error was taken, 0 first
  std::vector<double> held_out;  ///< mean over joints of residual / target mean square
  int best = 0;                  ///< index of the chosen entry
  int skipped = 0;               ///< iterations without a finite gradient
  double seconds = 0;
};

/// What friction has to explain when the rigid body is `arm`'s: the filtered torque less that of
/// the rigid body, along the motion that fits `filtered`.
/// @pre recordings were made from sequences
std::vector<TorqueData> torque_data(const Arm& arm, std::span<const Filtered> sequences,
                                    std::span<const Recording> recordings, bool filtered);

/// Minimises the error of the friction torque along windows of measured motion by Adam, over the
/// parameters of friction alone, by truncated back-propagation through its state; the states at the
/// windows' starts come from `wash_out`. Takes any friction of the tables. Returns the parameters
/// with the smallest error on the held-out part met on the way. Deterministic for a seed, whatever
/// `jobs`.
/// @throws UserError when a recording is too short for a window; Stopped on Ctrl-C
TorqueReport train_torque(const Arm& start, std::span<const TorqueData> data,
                          const TorqueOptions& options, std::string_view label, int jobs);

}  // namespace fricid::estimate
