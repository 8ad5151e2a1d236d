// What the doctor says about a log: one finding per kind of damage and place.
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "fricid/data/dataset.hpp"
#include "fricid/data/diagnosis_file.hpp"

namespace fricid::doctor {

using data::Severity;

/// Kinds of findings and what to do about them; the names are those of `--fix`.
struct Kind {
  std::string_view name;         ///< "gap"
  Severity severity;             //
  std::string_view consequence;  ///< what a fit would suffer
  std::string_view remedy;       ///< what the user can do
  bool fixable;                  ///< `repair` can
  bool misleads = false;         ///< a fit would be wrong, not only less accurate
};
std::span<const Kind> kinds();
/// @pre `name` is one of them
const Kind& kind_of(std::string_view name);

/// One thing found.
struct Finding {
  std::string name{};       ///< Kind::name
  std::string signal{};     ///< t, q, v, tau, temperature, or "q tau" for both
  int joint = -1;           ///< -1: all joints
  int other = -1;           ///< second joint of a swap
  double begin_s = 0;       ///< time span it was seen in [s]
  double end_s = 0;         //
  double size = 0;          ///< how much, in `unit`
  std::string unit{};       //
  int count = 1;            ///< how often
  std::vector<int> rows{};  ///< samples that `repair` changes; empty for kinds without
};

inline bool is_damage(const Finding& finding) {
  return kind_of(finding.name).severity == Severity::kDamage;
}

/// One line: "damage: swapped: q tau of joint_a4 and joint_a5, 0-31.4 s: ...".
std::string to_text(const Finding& finding, const data::Dataset& dataset);
/// All findings as an artefact.
data::DiagnosisFile diagnosis_file(std::span<const Finding> findings, const data::Dataset& dataset);

}  // namespace fricid::doctor
