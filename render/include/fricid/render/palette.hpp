// The models of a run and their colours, dashes and markers, the same in figures, video and report.
#pragma once

#include <string>
#include <vector>

#include "fricid/evaluate/evaluation.hpp"
#include "fricid/workflow/run_folder.hpp"

namespace fricid::render {

/// How one model is drawn. The colour says the law (Okabe & Ito 2008: safe for colour-blind
/// readers); dash and marker repeat it for print in grey.
struct Look {
  std::string colour = "#000000";  ///< "#rrggbb"
  int dash = 1;                    ///< 1 solid, 2 dashed, 3 dotted, 4 dash-dot
  int marker = 7;                  ///< gnuplot point type
};

/// The look of the `again`-th model of a law (0 for the first): the law's hue, then paler and
/// darker, each with another dash.
Look look_of_law(const std::string& law, int again = 0);

/// Colour of the truth and of measurements.
inline constexpr const char* kTruthColour = "#a6a6a6";
inline constexpr const char* kMeasuredColour = "#000000";

/// A model of a run.
struct RunModel {
  std::string name, label;
  std::string law;  ///< of its first joint; "oracle": the truth itself; "external": rollouts alone
  std::vector<int> seeds;  ///< ascending as in the evaluation
  bool is_oracle = false;
  Look look;

  /// The fit that represents the model in figures.
  workflow::FitId first_fit() const { return {name, seeds.front()}; }
};

/// The models of a run in the order of its evaluation, the engine's oracle first; the simulator's
/// oracle, equal to it, is left out.
/// @throws UserError when a model file is damaged
std::vector<RunModel> models_of_run(const evaluate::Evaluation& evaluation,
                                    const workflow::RunFolder& run);

}  // namespace fricid::render
