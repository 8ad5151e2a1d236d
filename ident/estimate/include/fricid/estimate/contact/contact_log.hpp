// External torque over a whole log.
#pragma once

#include <cstdint>

#include "fricid/data/contact_file.hpp"
#include "fricid/data/dataset.hpp"
#include "fricid/data/model_file.hpp"

namespace fricid::estimate {

struct ObserverOptions {
  double bandwidth_hz = 10;
  /// 0: friction follows the measured motion in open loop; else so many particles (OnlineEstimator)
  /// estimate its states while the arm moves.
  int particles = 0;
  std::uint64_t seed = 1;
};

/// The momentum observer of a model over a log, at the joints. Where positions or torques are
/// missing it is restarted behind them. At first and then its results are NaN until it has settled:
/// for five of its time constants and until a joint that moves as the log begins, or moved unseen,
/// has left 5 mrad behind. What stands as the log begins is touched by nothing: its friction holds
/// what the torque is beside gravity. Friction follows the positions as through a play of 2.5
/// standard deviations of the noise of their encoders, in which a joint at rest would lose what it
/// holds. While no joint leaves 5 mrad for half a second, particles cannot tell a push from
/// friction: it follows the motion there as without them.
/// @throws UserError when the joints differ, or particles have no noise model; Stopped on Ctrl-C
data::ContactSignals observe_log(const data::ModelFile& model, const data::Dataset& log,
                                 const ObserverOptions& options);

}  // namespace fricid::estimate
