// What the doctor says about a log: one finding per kind of damage and place.
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "fricid/data/dataset.hpp"
#include "fricid/data/diagnosis_file.hpp"

namespace fricid::doctor {

using data::FindingKind;
using data::Severity;

/// What a kind of finding means and what to do about it.
struct KindInfo {
  FindingKind kind;
  Severity severity;             //
  std::string_view consequence;  ///< what a fit would suffer
  std::string_view remedy;       ///< what the user can do
  bool fixable;                  ///< `repair` can
  bool misleads = false;         ///< a fit would be wrong, however large it is
};
const KindInfo& info_of(FindingKind kind);

/// One thing found.
struct Finding {
  FindingKind kind = FindingKind::kRate;
  std::string signal{};     ///< t, q, v, tau, temperature, or "q tau" for both
  int joint = -1;           ///< -1: all joints
  int other = -1;           ///< second joint of a swap
  double begin_s = 0;       ///< time span it was seen in [s]
  double end_s = 0;         //
  double size = 0;          ///< how much, in `unit`
  std::string unit{};       //
  int count = 1;            ///< how often
  std::vector<int> rows{};  ///< samples that `repair` changes; empty for kinds without
  bool is_severe = false;   ///< misleads, though others of its kind do not
};

/// Whether a fit would be wrong, not only less accurate.
inline bool misleads(const Finding& finding) {
  return finding.is_severe || info_of(finding.kind).misleads;
}

inline Severity severity_of(const Finding& finding) {
  return finding.is_severe ? Severity::kDamage : info_of(finding.kind).severity;
}

inline bool is_damage(const Finding& finding) { return severity_of(finding) == Severity::kDamage; }

/// Whether to tell of it unasked: damage, missing samples, torque at the limit of the drive, and
/// positions beyond their limits.
inline bool is_told(const Finding& finding) {
  return is_damage(finding) || finding.kind == FindingKind::kAtLimit ||
         finding.kind == FindingKind::kBeyondLimit || finding.kind == FindingKind::kMissing;
}

/// One line: "damage: swapped: q tau of joint_a4 and joint_a5, 0-31.4 s: ...".
std::string to_text(const Finding& finding, const data::Dataset& dataset);
/// The same of several data sets, each line behind their names: equal findings of several joints
/// or sets are one line, with the time from the first to the last and sizes from least to most.
/// @param which  of the findings; none: all
std::vector<std::string> to_lines(std::span<const std::vector<Finding>> findings,
                                  std::span<const data::Dataset> sets,
                                  bool (*which)(const Finding&) = nullptr);
/// All findings as an artefact.
data::DiagnosisFile diagnosis_file(std::span<const Finding> findings, const data::Dataset& dataset);

}  // namespace fricid::doctor
