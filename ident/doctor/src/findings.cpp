#include <fmt/format.h>
#include <fmt/ranges.h>

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
    KindInfo{FindingKind::kOutOfOrder, kDamage,
             "rows are behind later ones, as of two threads that write one file: the motion seems "
             "to leap back",
             "write from one thread, or --fix out_of_order sorts them by time", true},
    KindInfo{FindingKind::kRestart, kDamage,
             "two recordings in one file; nothing else was examined",
             "split the file there, a recording each", false, true},
    KindInfo{FindingKind::kInTurn, kDamage,
             "rows of several sources, as of two robots, follow each other; nothing else was "
             "examined",
             "a file for each source", false, true},
    KindInfo{
        FindingKind::kLost, kDamage,
        "rows are lost where the time runs on: speed and acceleration leap there, and all that "
        "follows comes too early",
        "log the controller's own time stamps, or a counter of samples as time; --fix lost lets "
        "the time run on and leaves those rows missing",
        true},
    KindInfo{FindingKind::kWrap, kDamage,
             "the time goes back where its counter is full, or a minute",
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
    KindInfo{FindingKind::kMissing, kNote,
             "these samples, and those as near as a filter of the fit reaches, take no part in it",
             "log every channel at every sample; where one comes less often, log all at its rate",
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
    KindInfo{
        FindingKind::kUnsigned, kDamage,
        "never on the other side of zero, to which it comes again and again: an absolute value",
        "log the torque with its sign", false, true},
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
             "scale of [position] in the contract: metres per raw value of a sliding joint", false,
             true},
    KindInfo{FindingKind::kBeyondLimit, kNote,
             "its zero or its sign may be another than that of the robot's file, or the limits are "
             "not this robot's",
             "compare a pose of the log with the arm", false},
    KindInfo{FindingKind::kTorqueUnit, kDamage, "all masses and friction are scaled",
             "correct kind, gear_ratio or scale of [torque] in the contract, or the masses of the "
             "robot's file",
             false, true},
    KindInfo{
        FindingKind::kMount, kDamage,
        "gravity points another way, or the zero of a joint is far off: signs and masses seem "
        "wrong",
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
             "or --fix delay moves the torque back; what a filter takes from the torque, neither "
             "does",
             true, true},
    KindInfo{FindingKind::kLowPass, kDamage,
             "the torque went through a filter that takes what friction and inertia do fast",
             "log it unfiltered, or with a corner far above the motion; moving it back in time "
             "does not undo it",
             false, true},
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

/// A finding, or equal ones of several joints and data sets.
struct Line {
  FindingKind kind;
  Severity severity;
  std::string signal, unit;
  std::vector<std::string> sets, joints;
  bool of_pair = false;   ///< its joints belong together
  bool of_all = false;    ///< its joints are all of the robot
  double begin_s, end_s;  ///< from the first to the last
  double least, most;     ///< sizes
  int count;

  void add(const Line& other) {
    begin_s = std::min(begin_s, other.begin_s);
    end_s = std::max(end_s, other.end_s);
    least = std::min(least, other.least);
    most = std::max(most, other.most);
    count += other.count;
  }
};

Line line_of(const Finding& f, const data::Dataset& d) {
  Line line{.kind = f.kind,
            .severity = severity_of(f),
            .signal = f.signal,
            .unit = f.unit,
            .sets = {d.name},
            .joints = {},
            .of_pair = f.other >= 0,
            .of_all = false,
            .begin_s = f.begin_s,
            .end_s = f.end_s,
            .least = f.size,
            .most = f.size,
            .count = f.count};
  for (const int j : {f.joint, f.other})
    if (j >= 0) line.joints.push_back(d.joint_names[static_cast<std::size_t>(j)]);
  return line;
}

bool are_alike(const Line& a, const Line& b) {
  return a.kind == b.kind && a.severity == b.severity && a.signal == b.signal && a.unit == b.unit;
}

/// The findings of one data set, equal ones of several joints as one.
std::vector<Line> lines_of(std::span<const Finding> findings, const data::Dataset& d,
                           bool (*which)(const Finding&)) {
  std::vector<Line> lines;
  for (const Finding& finding : findings) {
    if (which && !which(finding)) continue;
    const Line line = line_of(finding, d);
    const bool of_joint = finding.joint >= 0 && !line.of_pair;
    const auto same = std::ranges::find_if(lines, [&](const Line& other) {
      return of_joint && !other.of_pair && !other.joints.empty() && are_alike(line, other);
    });
    if (same == lines.end()) {
      lines.push_back(line);
      continue;
    }
    same->add(line);
    if (std::ranges::count(same->joints, line.joints[0]) == 0)
      same->joints.push_back(line.joints[0]);
  }
  for (Line& line : lines) line.of_all = d.n() > 2 && std::ssize(line.joints) == d.n();
  return lines;
}

std::string in_words(const Line& line) {
  const KindInfo& kind = info_of(line.kind);
  const std::string joints =
      line.of_all ? "all joints"
                  : fmt::format("{}", fmt::join(line.joints, line.of_pair ? " and " : ", "));
  const std::string least = fmt::format("{:.4g}", line.least),
                    most = fmt::format("{:.4g}", line.most);
  std::string text = fmt::format(
      "{}: {}: {}{}{}, {:.6g} to {:.6g} s: {}{}{} {}", name_of(line.severity), name_of(kind.kind),
      line.signal, joints.empty() ? "" : " of ", joints, line.begin_s, line.end_s, least,
      least == most ? "" : " to ", least == most ? "" : most, line.unit);
  while (text.ends_with(' ')) text.pop_back();
  if (line.count > 1) text += fmt::format(" ({} times)", line.count);
  if (!kind.consequence.empty()) text += fmt::format("; {}", kind.consequence);
  if (!kind.remedy.empty()) text += fmt::format("; remedy: {}", kind.remedy);
  return text;
}

/// "train_0", "train_0, train_1", "train_0 and 5 others".
std::string names_of(const std::vector<std::string>& sets) {
  constexpr std::size_t kMost = 3;
  if (sets.size() <= kMost) return fmt::format("{}", fmt::join(sets, ", "));
  return fmt::format("{} and {} others", sets.front(), sets.size() - 1);
}

}  // namespace

const KindInfo& info_of(FindingKind kind) { return kKinds[static_cast<std::size_t>(kind)]; }

std::string to_text(const Finding& f, const data::Dataset& d) { return in_words(line_of(f, d)); }

std::vector<std::string> to_lines(std::span<const std::vector<Finding>> findings,
                                  std::span<const data::Dataset> sets,
                                  bool (*which)(const Finding&)) {
  std::vector<Line> all;
  for (std::size_t i = 0; i < sets.size(); ++i)
    for (const Line& line : lines_of(findings[i], sets[i], which)) {
      const auto same = std::ranges::find_if(all, [&](const Line& other) {
        return are_alike(line, other) && line.joints == other.joints &&
               line.of_pair == other.of_pair && other.sets.back() != line.sets[0];
      });
      if (same == all.end()) {
        all.push_back(line);
        continue;
      }
      same->add(line);
      same->sets.push_back(line.sets[0]);
    }
  std::vector<std::string> text;
  for (const Line& line : all)
    text.push_back(fmt::format("{}: {}", names_of(line.sets), in_words(line)));
  return text;
}

data::DiagnosisFile diagnosis_file(std::span<const Finding> findings, const data::Dataset& d) {
  data::DiagnosisFile file{
      .data = d.name, .source = d.source, .log = {}, .joints = d.joint_names, .findings = {}};
  for (const Finding& f : findings) {
    const KindInfo& kind = info_of(f.kind);
    data::DiagnosedFinding& own = file.findings.emplace_back();
    own = {.kind = f.kind,
           .severity = severity_of(f),
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
