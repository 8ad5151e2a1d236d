#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "fricid/doctor/finding.hpp"

namespace fricid::doctor {
namespace {

constexpr Severity kNote = Severity::kNote, kDamage = Severity::kDamage;

constexpr std::array kKinds{
    Kind{"rate", kNote, "", "", false},
    Kind{"gap", kDamage, "motion is differentiated across lost samples",
         "log without losses, or --fix gap: missing samples are left out of fits", true},
    Kind{"duplicate", kDamage, "two samples of one time: velocity is infinite there",
         "--fix duplicate drops the later one", true},
    Kind{"jitter", kDamage, "velocity and acceleration are noisy",
         "log the controller's own time stamps; if samples are taken evenly, --fix jitter", true},
    Kind{"clock_drift", kDamage, "speed and inertia are scaled by the clock's error",
         "log the controller's own clock; if samples are taken evenly, --fix clock_drift", true},
    Kind{"missing", kDamage, "these samples take no part in a fit", "log them", false},
    Kind{"quantised", kDamage,
         "friction before sliding is hidden between the steps, acceleration is noise",
         "log more digits (KUKA RSI: raise Precision of the ETHERNET object)", false},
    Kind{"stuck", kDamage, "the signal is no measurement there", "log this channel again", false,
         true},
    Kind{"still", kDamage, "of this joint neither friction nor inertia can be identified",
         "move it, or weld it in the URDF: type=\"fixed\"", false},
    Kind{"saturated", kDamage, "what lies beyond the limit is lost; large torques look small",
         "move more slowly, or widen the range of the logged channel", false},
    Kind{"spike", kDamage, "single wrong samples weigh much in a fit",
         "--fix spike makes them missing", true},
    Kind{"jump", kDamage, "an infinite velocity, another pose afterwards",
         "--fix jump takes whole turns out; else log again", true, true},
    Kind{"repeated", kDamage, "stale packets: the motion seems to stop and leap",
         "log in step with the controller, or --fix repeated makes them missing", true},
    Kind{"velocity", kDamage, "the logged velocity contradicts the position",
         "correct unit, sign or gear in the contract, or --fix velocity leaves it out", true},
    Kind{"angle_unit", kDamage, "a position in degrees is 57 times too large",
         "unit = \"deg\" in the contract, or --fix angle_unit", true, true},
    Kind{"torque_unit", kDamage, "all masses and friction are scaled",
         "correct kind, gear_ratio or scale of [torque] in the contract", false, true},
    Kind{"mount", kDamage, "gravity is the wrong way round: signs and masses seem wrong",
         "mount of [robot] in the scene; --mount of import and check", false, true},
    Kind{"sign", kDamage, "friction would drive the joint; inertia would be negative",
         "sign in the contract, or --fix sign", true, true},
    Kind{"swapped", kDamage, "two joints are identified as each other",
         "order of columns in the contract, or --fix swapped", true, true},
    Kind{"delay", kDamage, "friction and inertia leak into each other",
         "log both in the same cycle, or --fix delay moves the torque back", true, true},
    Kind{"delay_unknown", kDamage, "friction and inertia leak into each other",
         "log motion and torque by one clock, and move fast enough that a delay shows", false,
         true},
    Kind{"temperature_unit", kDamage, "temperature laws need kelvin",
         "unit = \"C\" in the contract, or --fix temperature_unit", true, true},
    Kind{"temperature_trend", kNote, "friction drifts while the gears warm up", "", false},
    Kind{"segments", kNote, "", "", false},
};

std::string joint_of(const Finding& f, const data::Dataset& d) {
  if (f.joint < 0) return "";
  std::string names = d.joint_names[static_cast<std::size_t>(f.joint)];
  if (f.other >= 0) names += " and " + d.joint_names[static_cast<std::size_t>(f.other)];
  return names;
}

}  // namespace

std::span<const Kind> kinds() { return kKinds; }

const Kind& kind_of(std::string_view name) {
  return *std::find_if(kKinds.begin(), kKinds.end(), [&](const Kind& k) { return k.name == name; });
}

std::string to_text(const Finding& f, const data::Dataset& d) {
  const Kind& kind = kind_of(f.name);
  const std::string joint = joint_of(f, d);
  std::string text =
      fmt::format("{}: {}: {}{}{}, {:.6g} to {:.6g} s: {:.4g} {}", name_of(kind.severity), f.name,
                  f.signal, joint.empty() ? "" : " of ", joint, f.begin_s, f.end_s, f.size, f.unit);
  while (text.ends_with(' ')) text.pop_back();
  if (f.count > 1) text += fmt::format(" ({} times)", f.count);
  if (!kind.consequence.empty()) text += fmt::format("; {}", kind.consequence);
  if (!kind.remedy.empty()) text += fmt::format("; remedy: {}", kind.remedy);
  return text;
}

data::DiagnosisFile diagnosis_file(std::span<const Finding> findings, const data::Dataset& d) {
  data::DiagnosisFile file{
      .data = d.name, .source = d.source, .joints = d.joint_names, .findings = {}};
  for (const Finding& f : findings) {
    const Kind& kind = kind_of(f.name);
    data::DiagnosedFinding& own = file.findings.emplace_back();
    own = {.name = f.name,
           .severity = kind.severity,
           .misleads = kind.misleads,
           .signal = f.signal,
           .joints = {},
           .begin_s = f.begin_s,
           .end_s = f.end_s,
           .size = f.size,
           .unit = f.unit,
           .count = f.count,
           .consequence = std::string(kind.consequence),
           .remedy = std::string(kind.remedy)};
    for (const int j : {f.joint, f.other})
      if (j >= 0) own.joints.push_back(d.joint_names[static_cast<std::size_t>(j)]);
  }
  return file;
}

}  // namespace fricid::doctor
