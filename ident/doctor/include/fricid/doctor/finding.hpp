// What the doctor says about a log: one finding per kind of damage and place.
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "fricid/base/field.hpp"
#include "fricid/data/dataset.hpp"

namespace fricid::doctor {

enum class Severity {
  kNote,    ///< a fact worth knowing: rate, segments, warming
  kDamage,  ///< a fit would be wrong or poor
};

/// Kinds of findings and what to do about them; the names are those of `--fix`.
struct Kind {
  std::string_view name;         ///< "gap"
  Severity severity;             //
  std::string_view consequence;  ///< what a fit would suffer
  std::string_view remedy;       ///< what the user can do
  bool fixable;                  ///< `repair` can
  bool misleads = false;         ///< a fit would mean something else, not only be poorer
};
std::span<const Kind> kinds();
/// @pre `name` is one of them
const Kind& kind_of(std::string_view name);

/// One thing found.
struct Finding {
  std::string name{};       ///< of its Kind
  std::string signal{};     ///< t, q, v, tau, temperature, or "q tau" for both
  int joint = -1;           ///< -1: all joints
  int other = -1;           ///< second joint of a swap
  double begin_s = 0;       ///< time span it was seen in [s]
  double end_s = 0;         //
  double size = 0;          ///< how much, in `unit`
  std::string unit{};       //
  int count = 1;            ///< how often
  std::vector<int> rows{};  ///< samples that `repair` acts on, where it needs them
};

inline bool is_damage(const Finding& finding) {
  return kind_of(finding.name).severity == Severity::kDamage;
}

/// One line: "damage: swapped: q tau of joint_a4 and joint_a5, 0-31.4 s: ...".
std::string to_text(const Finding& finding, const data::Dataset& dataset);

/// A finding as its file has it.
struct WrittenFinding {
  std::string name, severity;
  bool misleads = false;
  std::string signal;
  std::vector<std::string> joints;
  double begin_s = 0, end_s = 0, size = 0;
  std::string unit;
  int count = 1;
  std::string consequence, remedy;

  template <class Archive>
  void visit(Archive& archive) {
    archive("name", name, text("kind of the finding, as for --fix"));
    archive("severity", severity, choice("note|damage", "whether a fit suffers"));
    archive("misleads", misleads, flag("a fit would mean something else, not only be poorer"));
    archive("signal", signal, text("t, q, v, tau, temperature, or \"q tau\" for both"));
    archive("joints", joints, text("those concerned; empty: all"));
    archive("begin_s", begin_s, number("s", -1e12, 1e12, "where it was seen"));
    archive("end_s", end_s, number("s", -1e12, 1e12, "where it was seen"));
    archive("size", size, number("", -1e300, 1e300, "how much, in `unit`"));
    archive("unit", unit, text("of the size"));
    archive("count", count, number("", 0, 1e9, "how often"));
    archive("consequence", consequence, text("what a fit would suffer"));
    archive("remedy", remedy, text("what to do"));
  }
};

/// What is wrong with a recording: the file data/RECORDING.doctor.json of a run folder.
struct Diagnosis {
  static constexpr std::string_view kFormat = "fricid.doctor/1";

  std::string data, source;
  std::vector<std::string> joints;
  std::vector<WrittenFinding> findings;

  template <class Archive>
  void visit(Archive& archive) {
    archive("data", data, text("name of the recording"));
    archive("source", source, text("where it came from"));
    archive("joints", joints, text("names of the joints"));
    archive.sections("findings", findings, "what was found");
  }
};

Diagnosis diagnosis_of(std::span<const Finding> findings, const data::Dataset& dataset);

}  // namespace fricid::doctor
