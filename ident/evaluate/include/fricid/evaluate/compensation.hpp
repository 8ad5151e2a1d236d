// Scores of closed loops with the friction of models fed forward: the file compensation.json.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "fricid/base/field.hpp"
#include "fricid/data/loop_file.hpp"

namespace fricid::evaluate {

/// Score of one closed loop; errors are those of the true position against the desired one.
struct LoopScore {
  std::string model;  ///< "none": nothing is fed forward, "truth": the injected friction
  std::string label;
  double gain = 0;
  int controller = 0, path = 0;       ///< index of its bandwidth and of the path
  double bandwidth_hz = 0, size = 0;  ///< of the controller, of the path
  double peak_rad_s = 0;              ///< fastest desired speed of any joint
  bool diverged = false;              ///< an error beyond 1 rad; the others are those until there
  /// (n) RMS within 0.2 s after the desired velocity of the joint changed its sign, and elsewhere.
  std::vector<double> reversal_rad, sliding_rad;
  double feedback_J = 0;                  ///< integral of sum_j |tau_feedback,j v_j|
  std::vector<std::string> limit_cycles;  ///< joints that swing while the reference rests

  template <class Archive>
  void visit(Archive& archive) {
    archive("model", model, text("fed forward; none: nothing; truth: the injected friction"));
    archive("label", label, text("for tables and plots"));
    archive("gain", gain, number("1", 0, 10, "factor on the fed forward friction"));
    archive("controller", controller, number("", 0, 1e6, "index of its bandwidth, as in loops/"));
    archive("path", path, number("", 0, 1e6, "index of the path, as in loops/"));
    archive("bandwidth_hz", bandwidth_hz, number("Hz", 0, 1000, "of the controller"));
    archive("size", size, number("1", 0, 1, "of the path"));
    archive("peak_rad_s", peak_rad_s, number("rad/s", 0, 1e6, "fastest desired speed of a joint"));
    archive("diverged", diverged, flag("an error went beyond 1 rad; scores are those until there"));
    archive(
        "reversal_rad", reversal_rad,
        number("rad", 0, 1e6,
               "per joint, RMS error within 0.2 s after its desired velocity changed its sign"));
    archive("sliding_rad", sliding_rad, number("rad", 0, 1e6, "per joint, RMS error elsewhere"));
    archive(
        "feedback_J", feedback_J,
        number("J", 0, 1e12, "integral of the feedback's power, absolute values of the joints"));
    archive("limit_cycles", limit_cycles,
            text("joints that keep swinging by more than 0.05 mrad while the reference rests"));
  }
};

struct CompensationFile {
  static constexpr std::string_view kFormat = "fricid.compensation/1";

  std::string drive;  ///< of the friction's states: reference or measured
  double path_s = 0;  ///< length of a path
  std::vector<LoopScore> loops;

  template <class Archive>
  void visit(Archive& archive) {
    archive("drive", drive, text("motion that drives the fed forward friction"));
    archive("path_s", path_s, number("s", 0, 1e9, "length of a path; rest follows"));
    archive.sections("loops", loops, "closed loops that were simulated");
  }
};

/// Scores the signals of a loop.
/// @param path_s  when the path ends and the rest begins [s]
/// @return with errors and energy alone: the rest the signals do not tell
LoopScore score_loop(const data::LoopSignals& loop, double path_s);

/// What is fed forward beside the models of a run.
inline constexpr const char *kNoModel = "none", *kTruthModel = "truth";

/// RMS over joints.
double rms(const std::vector<double>& of_joints);

/// Geometric mean over all paths and bandwidths of the error of a model at a gain over that of
/// another, both at reversals. NaN without a common one.
double reversal_ratio(const CompensationFile& file, std::string_view model, double gain,
                      std::string_view other);

/// Tables at every gain: errors, energy, joints in a limit cycle.
std::string to_markdown(const CompensationFile& file);

}  // namespace fricid::evaluate
