#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "fricid/doctor/finding.hpp"

namespace fricid::doctor {
namespace {

constexpr Severity kNote = Severity::kNote, kDamage = Severity::kDamage;

constexpr std::array kKinds{
    KindInfo{FindingKind::kRate, kNote, "", "", false},
    KindInfo{FindingKind::kGap, kDamage, "motion is differentiated across lost samples",
             "log without losses, or --fix gap: missing samples are left out of fits", true},
    KindInfo{FindingKind::kDuplicate, kDamage,
             "two samples of one time: velocity is infinite there",
             "--fix duplicate drops the later one", true},
    KindInfo{FindingKind::kRestart, kDamage,
             "two recordings in one file; nothing else was examined",
             "split the file there, a recording each", false, true},
    KindInfo{FindingKind::kWrap, kDamage, "the time goes back where its counter is full",
             "--fix wrap lets it go on; or log a counter of 64 bits", true, true},
    KindInfo{FindingKind::kJitter, kDamage, "velocity and acceleration are noisy",
             "log the controller's own time stamps; if samples are taken evenly, --fix jitter",
             true},
    KindInfo{FindingKind::kUneven, kDamage,
             "samples are taken at the stamps, at which the motion is smooth; fits need even times",
             "--fix uneven interpolates at even times", true},
    KindInfo{FindingKind::kClockDrift, kDamage, "speed and inertia are scaled by the clock's error",
             "log the controller's own clock; if samples are taken evenly, --fix clock_drift",
             true},
    KindInfo{FindingKind::kMissing, kDamage, "these samples take no part in a fit", "log them",
             false},
    KindInfo{
        FindingKind::kQuantised, kDamage,
        "friction before sliding is hidden between the steps; of a position acceleration is noise",
        "log more digits (KUKA RSI: raise Precision of the ETHERNET object)", false},
    KindInfo{FindingKind::kStuck, kDamage, "the signal is no measurement there",
             "log this channel again; where the drives were off, leave that time out", false, true},
    KindInfo{FindingKind::kSame, kDamage, "one column under two headers: one joint was not logged",
             "log the channel of each joint under its own header; fix one of two fingers that one "
             "motor moves",
             false, true},
    KindInfo{FindingKind::kConstant, kDamage,
             "a torque that was not logged: of this joint nothing can be identified",
             "log it, or name its column in [torque] of the contract", false, true},
    KindInfo{FindingKind::kStill, kDamage,
             "of this joint neither friction nor inertia can be identified",
             "move it, hold it ([robot] hold), or weld it in the URDF: type=\"fixed\"", false},
    KindInfo{
        FindingKind::kSaturated, kDamage,
        "what lies beyond the limit is lost; large torques look small",
        "move more slowly, or widen the range of the logged channel; if the drive gave no more, "
        "effort of the joint's <limit> in the URDF is to say so; --fix saturated makes the samples "
        "at the limit missing",
        true},
    KindInfo{FindingKind::kAtLimit, kNote,
             "the drive was at its limit in the robot's file: taken as the torque that it gave", "",
             false},
    KindInfo{FindingKind::kSpike, kDamage, "single wrong samples weigh much in a fit",
             "--fix spike makes them missing", true},
    KindInfo{FindingKind::kJump, kDamage, "an infinite velocity, another pose afterwards",
             "--fix jump takes whole turns out; any other: log again", true, true},
    KindInfo{FindingKind::kRepeated, kDamage, "stale packets: the motion seems to stop and leap",
             "log in step with the controller, or --fix repeated makes them missing", true},
    KindInfo{FindingKind::kHeld, kDamage,
             "old values beside new ones: the motion seems to stop and leap, or torque comes late",
             "log at the rate of the source; --fix held keeps the row of each new value", true},
    KindInfo{FindingKind::kVelocity, kDamage,
             "the logged velocity contradicts the position; no fit reads it",
             "correct unit, sign or gear in the contract, or --fix velocity leaves it out", true},
    KindInfo{FindingKind::kAngleUnit, kDamage, "a position in degrees is 57 times too large",
             "unit = \"deg\" in the contract, or --fix angle_unit", true, true},
    KindInfo{FindingKind::kLengthUnit, kDamage, "speed and friction of this joint are scaled",
             "scale of [position] in the contract: metres per raw value of a sliding joint, times "
             "57.2958 where the unit is deg",
             false, true},
    KindInfo{FindingKind::kTorqueUnit, kDamage, "all masses and friction are scaled",
             "correct kind, gear_ratio or scale of [torque] in the contract", false, true},
    KindInfo{
        FindingKind::kMount, kDamage, "gravity points another way: signs and masses seem wrong",
        "measure the mount, which is found by the masses of the robot's file: mount of [robot] "
        "in the scene, --mount of import and check",
        false, true},
    KindInfo{FindingKind::kNoGravity, kDamage,
             "a fit finds masses that balance themselves, and no model holds in open loop",
             "log the whole torque of the motors, or add what the driver takes off for gravity to "
             "the column",
             false, true},
    KindInfo{FindingKind::kSign, kDamage,
             "friction would drive the joint, or masses lie on its other side",
             "sign in the contract, or --fix sign", true, true},
    KindInfo{FindingKind::kSwapped, kDamage, "two joints are identified as each other",
             "order of columns in the contract, or --fix swapped", true, true},
    KindInfo{FindingKind::kCoupled, kDamage, "friction and inertia of coupled joints are mixed",
             "of columns of motors [[coupling]] in the contract, with kind = \"motor_torque\" or "
             "unit = \"motor_rad\" (gear_ratio 1 where it is in them); of joints neither",
             false, true},
    KindInfo{FindingKind::kDelay, kDamage, "friction and inertia leak into each other",
             "log both in the same cycle; delay_s of [torque] in the contract, where it is known, "
             "or --fix delay moves the torque back",
             true, true},
    KindInfo{FindingKind::kDelayUnknown, kDamage, "friction and inertia leak into each other",
             "log motion and torque by one clock, and move fast enough that a delay shows", false,
             true},
    KindInfo{FindingKind::kTemperatureUnit, kDamage, "temperature laws need kelvin",
             "unit = \"C\" in the contract, or --fix temperature_unit", true, true},
    KindInfo{FindingKind::kTemperatureTrend, kNote, "friction drifts while the gears warm up", "",
             false},
    KindInfo{FindingKind::kSegments, kNote, "", "", false},
};

static_assert(
    [] {
      for (std::size_t i = 0; i < kKinds.size(); ++i)
        if (static_cast<std::size_t>(kKinds[i].kind) != i) return false;
      return name_of(kKinds.back().kind) == "segments" &&
             name_of(static_cast<FindingKind>(kKinds.size())).empty();
    }(),
    "one row for each kind, in the order of the enum");

std::string joint_of(const Finding& f, const data::Dataset& d) {
  if (f.joint < 0) return "";
  std::string names = d.joint_names[static_cast<std::size_t>(f.joint)];
  if (f.other >= 0) names += " and " + d.joint_names[static_cast<std::size_t>(f.other)];
  return names;
}

}  // namespace

const KindInfo& info_of(FindingKind kind) { return kKinds[static_cast<std::size_t>(kind)]; }

std::string to_text(const Finding& f, const data::Dataset& d) {
  const KindInfo& kind = info_of(f.kind);
  const std::string joint = joint_of(f, d);
  std::string text = fmt::format(
      "{}: {}: {}{}{}, {:.6g} to {:.6g} s: {:.4g} {}", name_of(kind.severity), name_of(f.kind),
      f.signal, joint.empty() ? "" : " of ", joint, f.begin_s, f.end_s, f.size, f.unit);
  while (text.ends_with(' ')) text.pop_back();
  if (f.count > 1) text += fmt::format(" ({} times)", f.count);
  if (!kind.consequence.empty()) text += fmt::format("; {}", kind.consequence);
  if (!kind.remedy.empty()) text += fmt::format("; remedy: {}", kind.remedy);
  return text;
}

data::DiagnosisFile diagnosis_file(std::span<const Finding> findings, const data::Dataset& d) {
  data::DiagnosisFile file{
      .data = d.name, .source = d.source, .log = {}, .joints = d.joint_names, .findings = {}};
  for (const Finding& f : findings) {
    const KindInfo& kind = info_of(f.kind);
    data::DiagnosedFinding& own = file.findings.emplace_back();
    own = {.kind = f.kind,
           .severity = kind.severity,
           .misleads = misleads(f),
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
