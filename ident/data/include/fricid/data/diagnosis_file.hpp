// What is wrong with a recording: the files data/NAME.doctor.json of a run folder.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "fricid/base/enum_names.hpp"
#include "fricid/base/field.hpp"

namespace fricid::data {

enum class Severity {
  kNote,    ///< a fact worth knowing: rate, segments, warming
  kDamage,  ///< a fit would be wrong or poor
};
constexpr std::string_view names(Severity) { return "note|damage"; }

/// What can be wrong with a recording, and facts about it; the names are those of `--fix`.
enum class FindingKind {
  kRate,
  kGap,
  kDuplicate,
  kOutOfOrder,
  kRestart,
  kInTurn,
  kLost,
  kWrap,
  kJitter,
  kUneven,
  kClockDrift,
  kMissing,
  kQuantised,
  kStuck,
  kSame,
  kConstant,
  kUnsigned,
  kStill,
  kSaturated,
  kAtLimit,
  kSpike,
  kJump,
  kRepeated,
  kHeld,
  kVelocity,
  kAngleUnit,
  kLengthUnit,
  kBeyondLimit,
  kTorqueUnit,
  kMount,
  kNoGravity,
  kSign,
  kSwapped,
  kCoupled,
  kDelay,
  kLowPass,
  kDelayUnknown,
  kTemperatureUnit,
  kTemperatureTrend,
  kSegments
};
constexpr std::string_view names(FindingKind) {
  return "rate|gap|duplicate|out_of_order|restart|in_turn|lost|wrap|jitter|uneven|clock_drift|"
         "missing|quantised|"
         "stuck|same|constant|unsigned|still|saturated|at_limit|spike|jump|repeated|held|velocity|"
         "angle_unit|length_unit|beyond_limit|torque_unit|mount|no_gravity|sign|swapped|coupled|"
         "delay|low_pass|delay_unknown|temperature_unit|temperature_trend|segments";
}

/// One thing found.
struct DiagnosedFinding {
  FindingKind kind = FindingKind::kRate;
  Severity severity = Severity::kNote;
  bool misleads = false;
  std::string signal;
  std::vector<std::string> joints;
  double begin_s = 0, end_s = 0, size = 0;
  std::string unit;
  int count = 1;
  std::string consequence, remedy;

  template <class Archive>
  void visit(Archive& archive) {
    archive("name", kind, choice("what was found; the name that --fix takes"));
    archive("severity", severity, choice("damage: a fit would be wrong or poor"));
    archive("misleads", misleads, flag("a fit would be wrong, not only less accurate"));
    archive("signal", signal, text("t, q, v, tau, temperature, or \"q tau\" for both"));
    archive("joints", joints, text("joints concerned, two for a swap; empty: all"));
    archive("begin_s", begin_s, any_number("s", "start of the time span"));
    archive("end_s", end_s, any_number("s", "end of the time span"));
    archive("size", size, any_number("", "how much, in `unit`"));
    archive("unit", unit, text("of `size`"));
    archive("count", count, number("", 0, 2e9, "number of occurrences"));
    archive("consequence", consequence, text("effect on a fit; empty: none"));
    archive("remedy", remedy, text("what to do; empty: nothing"));
  }
};

/// The whole file.
struct DiagnosisFile {
  static constexpr std::string_view kFormat = "fricid.doctor/1";

  std::string data, source;
  std::optional<std::string> log;  ///< that was imported by itself
  std::vector<std::string> joints;
  std::vector<DiagnosedFinding> findings;

  template <class Archive>
  void visit(Archive& archive) {
    archive("data", data, text("name of the recording"));
    archive("source", source, text("where its samples come from"));
    archive("log", log, text("path of the log, of `fricid import` alone"));
    archive("joints", joints, text("names of its joints"));
    archive.sections("findings", findings,
                     "those of the times first, then of signals and dynamics");
  }
};

}  // namespace fricid::data
