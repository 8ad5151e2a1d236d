// Warnings about the results of a run, each with its remedy.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "fricid/data/fit_file.hpp"
#include "fricid/evaluate/evaluation.hpp"

namespace fricid::evaluate {

/// Sentences without a full stop, in plain text.
struct Warning {
  std::string subject;  ///< a model, a model's joint, a horizon or a recording
  std::string found, meaning, remedy;
};

Warning warning_of(const Unexplained& torque);

/// Models in doubt, recordings that do not belong, rollouts that diverged, horizons that cannot
/// rank models.
std::vector<Warning> warnings_of(const Evaluation& evaluation);

/// Parameters of a fit that ended on a bound; none: nothing to say.
/// @param name  of the model, for `subject`
std::optional<Warning> bounds_of(const data::FitFile& fit, const std::string& name);

/// Friction that grows with the load, of which the law of a fit knows nothing: the joints that show
/// it and by how much, with standard errors; none: it is not seen, or the law has it.
/// @param name    of the model, for `subject`
/// @param joints  names (n)
std::optional<Warning> growth_of(const data::FitFile& fit, const std::string& name,
                                 std::span<const std::string> joints);

/// Faults and outcome of a fit, parameters on a bound, several minima, a regression that is poorly
/// conditioned or uses few rows (conventional part); training that went astray (learned part).
/// @param name    of the model, for `subject`
/// @param joints  names (n)
std::vector<Warning> warnings_of(const data::FitFile& fit, const std::string& name,
                                 std::span<const std::string> joints);

/// An excitation that breaks a limit of the robot.
/// @param recording  its name
Warning infeasible_excitation(const std::string& recording);

}  // namespace fricid::evaluate
