// Training by back-propagation through open-loop windows.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "fricid/estimate/coordinates.hpp"
#include "fricid/estimate/options/multi_step.hpp"
#include "fricid/estimate/report.hpp"
#include "fricid/estimate/windows/windows.hpp"
#include "fricid/optimise/descent.hpp"
#include "fricid/signals/recording.hpp"

namespace fricid::estimate {

/// Recordings cut in time: the last `hold_out` of each is kept for choosing between parameters and
/// never trained on.
struct Split {
  std::vector<int> train_end;   ///< per recording: windows end at this sample or before
  std::vector<int> test_begin;  ///< per recording: held-out rollouts begin here or after
};
Split split_recordings(std::span<const signals::Recording> recordings, double hold_out);

/// Open-loop rollouts by which models are judged.
struct Rollouts {
  std::vector<Window> seconds;  ///< of one second
  std::vector<Window> whole;    ///< as long as the shortest held-out part
  int second = 0, length = 0;   ///< samples of either
};
/// Of the held-out parts: seconds that tile them, a long one each.
Rollouts held_out_rollouts(std::span<const signals::Recording> recordings, const Split& split);

/// log of the mean square error of q [log rad^2] of open-loop rollouts; fallen ones count as
/// `kFallenSquare`.
struct RolloutErrors {
  std::vector<double> seconds, whole;  ///< as in Rollouts

  /// Mean, each kind with half the weight; of the long ones alone if none is a second long.
  double mean() const;
};
/// Steps as `evaluate` does.
RolloutErrors rollout_errors(const Arm& arm, std::span<const signals::Recording> recordings,
                             const Rollouts& rollouts, StepOptions step, int jobs);
inline constexpr double kFallenSquare = 1;  // [rad^2]

/// Open-loop error on the held-out part: geometric mean [rad^2] of `rollout_errors` there.
double held_out_error(const Arm& arm, std::span<const signals::Recording> recordings,
                      const Split& split, StepOptions step, int jobs);

struct MultiStepReport {
  Outcome outcome = Outcome::kFailed;
  std::string message = "train_multi_step was not called";
  Arm arm;                           ///< best on the held-out part, the start included
  optimise::DescentHistory history;  ///< held-out errors in rad^2
  int leap = 0;                      ///< that training used
  double seconds = 0;
};

/// Minimises the window loss over random windows of the training part, all parameters of the arm
/// at once, and returns the parameters with the smallest held-out error met on the way: no
/// worse there than `start`. Where a check finds three times the best error, training goes on from
/// the best with 0.3 of the step length. Friction states at a window's start come from `wash_out`
/// and are not differentiated. Training leaps as far as `step.leap`, halved until a batch's
/// gradient is within 20 % of that at the steps of `judge`. Deterministic for a seed, whatever
/// `jobs`.
/// @throws UserError when a recording is shorter than two windows or the parameters are too many
/// for the optimiser; Stopped on Ctrl-C
MultiStepReport train_multi_step(const Arm& start, std::span<const signals::Recording> recordings,
                                 const MultiStepOptions& options, std::string_view label, int jobs);

}  // namespace fricid::estimate
