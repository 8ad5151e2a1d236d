// Stage S3: training by back-propagation through open-loop windows.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "fricid/estimate/coordinates.hpp"
#include "fricid/estimate/recording.hpp"
#include "fricid/estimate/report.hpp"
#include "fricid/estimate/windows/windows.hpp"

namespace fricid::estimate {

/// Recordings cut in time: the last `hold_out` of each is kept for choosing between parameters and
/// never trained on.
struct Split {
  std::vector<int> train_end;   ///< per recording: windows end at this sample or before
  std::vector<int> test_begin;  ///< per recording: held-out rollouts begin here or after
};
Split split_recordings(std::span<const Recording> recordings, double hold_out);

/// Open-loop error on the held-out part: geometric mean of the mean square error of q [rad^2] over
/// rollouts of one second that tile it and one over all of it per recording, each kind with half
/// the weight; fallen rollouts count as `kFallenSquare`. Steps as `evaluate` does.
double held_out_error(const Arm& arm, std::span<const Recording> recordings, const Split& split,
                      StepOptions step, int jobs);
inline constexpr double kFallenSquare = 1;  // [rad^2]

/// How the loss is minimised.
enum class Optimiser {
  kAdam,         ///< first order
  kGaussNewton,  ///< stochastic Gauss-Newton steps, for up to some thousand parameters
};
std::string_view to_string(Optimiser optimiser);

struct MultiStepOptions {
  std::optional<Optimiser> optimiser;  ///< none: Gauss-Newton up to 8000 parameters, else Adam
  double window_s = 0.25;
  int batch = 32;            ///< windows per iteration
  double from_rest = 0.125;  ///< share of them that begin with a recording
  int iterations = 0;        ///< 0: 2400 of Adam, 1000 of Gauss-Newton
  /// Step length, times 0.3 after 60 % and 0.1 after 85 % of the iterations; 0: 8e-3 of Adam, 1 of
  /// Gauss-Newton.
  double rate = 0;
  double hold_out = 0.2;    ///< share of every recording
  int wash_out_every = 20;  ///< iterations between refreshes of the friction states
  int checks = 10;          ///< how often the held-out error is looked at
  StepOptions step{8,
                   4};  ///< of training; leaps are shortened until they hold, see `leap_that_holds`
  StepOptions judge{8, 1};  ///< of the held-out rollouts
  ErrorScales scales;
  CoordinateOptions coordinates;
  std::uint64_t seed = 1;
};

struct MultiStepReport {
  Outcome outcome = Outcome::kFailed;
  std::string message = "train_multi_step was not called";
  Arm arm;                       ///< best on the held-out part, the start included
  std::vector<double> loss;      ///< per iteration, mean over the batch
  std::vector<int> checked;      ///< iterations after which the held-out error was taken, 0 first
  std::vector<double> held_out;  ///< [rad^2], one per entry of `checked`
  int best = 0;                  ///< index of the chosen entry
  int leap = 0;                  ///< that training used
  int skipped = 0;               ///< iterations without a finite gradient
  int returns = 0;               ///< how often it went back to the best and on with shorter steps
  double seconds = 0;
};

/// Minimises the window loss over random windows of the training part, all parameters of the arm
/// at once, and returns the parameters with the smallest held-out error met on the way: no
/// worse there than `start`. Where a look finds three times the best error, training goes on from
/// the best with 0.3 of the step length. Friction states at a window's start come from `wash_out`
/// and are not differentiated. Training leaps as far as `step.leap`, halved until a batch's
/// gradient is within 20 % of that at the steps of `judge`. Deterministic for a seed, whatever
/// `jobs`.
/// @throws UserError when a recording is shorter than two windows or the parameters are too many
/// for the optimiser; Stopped on Ctrl-C
MultiStepReport train_multi_step(const Arm& start, std::span<const Recording> recordings,
                                 const MultiStepOptions& options, std::string_view label, int jobs);

}  // namespace fricid::estimate
