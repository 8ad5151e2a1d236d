#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <utility>

#include "checks.hpp"
#include "fricid/base/unit_of_joint.hpp"
#include "fricid/doctor/doctor.hpp"
#include "fricid/signals/recording.hpp"

namespace fricid::doctor {
namespace {

// Single samples that are missing, and two or three together, taken from straight lines: without
// them a log of stale packets has no window that is whole.
void bridge(data::RowMatrix& x) {
  constexpr Eigen::Index kMost = 3;
  for (Eigen::Index j = 0; j < x.cols(); ++j)
    for (Eigen::Index k = 1; k < x.rows(); ++k) {
      if (std::isfinite(x(k, j)) || !std::isfinite(x(k - 1, j))) continue;
      Eigen::Index next = k;
      while (next < x.rows() && !std::isfinite(x(next, j))) ++next;
      if (next < x.rows() && next - k <= kMost) {
        const double before = x(k - 1, j);
        const double slope = (x(next, j) - before) / static_cast<double>(next - k + 1);
        for (Eigen::Index i = k; i < next; ++i)
          x(i, j) = before + slope * static_cast<double>(i - k + 1);
      }
      k = next;
    }
}

// Rows that every channel lost, such as the samples of a gap that was filled, are one finding.
void join_missing(const data::Dataset& d, Findings& findings) {
  const auto is_missing = [](const Finding& f) { return f.kind == FindingKind::kMissing; };
  const auto first = std::ranges::find_if(findings, is_missing);
  if (first == findings.end()) return;
  const auto is_alike = [is_missing, begin = first->begin_s, end = first->end_s,
                         size = first->size](const Finding& f) {
    return is_missing(f) && f.begin_s == begin && f.end_s == end && f.size == size;
  };
  if (std::ranges::count_if(findings, is_alike) < 2 * d.n()) return;
  Finding all = *first;
  all.joint = -1;
  all.signal = "q, tau";
  all.is_severe = false;
  std::erase_if(findings, is_alike);
  findings.insert(findings.begin(), std::move(all));
}

// Missing values so close to each other that hardly any filtered signal is without one.
void know_what_is_left(const data::Dataset& d, Findings& findings) {
  constexpr double kCutoff = 10;       // [Hz] of a fit, unless it is told another
  constexpr double kLeastLeft = 0.01;  // of the samples
  const std::vector<bool> made_up = signals::beside_missing(d, kCutoff);
  const auto left = static_cast<double>(std::ranges::count(made_up, false));
  if (left >= kLeastLeft * d.length()) return;
  for (Finding& f : findings) {
    if (f.kind != FindingKind::kMissing) continue;
    f.is_severe = true;
    f.unit += fmt::format("; {} left of the log, all else within {:g} s of one",
                          left == 0 ? "nothing is" : fmt::format("{:.2g} s are", left * d.dt()),
                          1 / kCutoff);
  }
}

// Torque that is constant at the effort limit of its joint is what the drive gave.
void know_limits(const dynamics::RobotModel& robot, Findings& findings) {
  constexpr double kSame = 0.01;  // of the limit
  for (Finding& f : findings) {
    if (f.kind != FindingKind::kSaturated || f.signal != "tau" || robot.coupled()) continue;
    const double effort = robot.joints[static_cast<std::size_t>(f.joint)].effort;
    if (std::abs(std::abs(f.size) - effort) > kSame * effort) continue;
    f.kind = FindingKind::kAtLimit;
    f.is_severe = false;
    f.rows.clear();
  }
}

// What is no measurement takes no part in a regression.
void leave_out(data::RowMatrix& x, const Finding& f, const Eigen::VectorXd& t) {
  for (const int j : {f.joint, f.other})
    for (Eigen::Index k = 0; k < x.rows() && j >= 0; ++k)
      if (t[k] >= f.begin_s && t[k] <= f.end_s) x(k, j) = std::numeric_limits<double>::quiet_NaN();
}

// Positions beyond the limits of the robot's file, where no other finding is about the position.
void check_limits(const data::Dataset& d, const dynamics::RobotModel& robot, Findings& findings) {
  constexpr double kClear = 0.01;  // [rad or m]
  if (std::ranges::any_of(findings, [](const Finding& f) {
        return misleads(f) && f.signal.find('q') != std::string::npos;
      }))
    return;
  for (int j = 0; j < d.n(); ++j) {
    const dynamics::Joint& joint = robot.joints[static_cast<std::size_t>(j)];
    if (joint.continuous || joint.upper <= joint.lower) continue;
    std::vector<int> rows;
    int farthest = 0;
    double most = 0;
    for (int k = 0; k < d.length(); ++k) {
      const double beyond = std::max(d.q(k, j) - joint.upper, joint.lower - d.q(k, j));
      if (!(beyond > kClear)) continue;
      rows.push_back(k);
      if (beyond > most) farthest = k;
      most = std::max(most, beyond);
    }
    if (!rows.empty())
      findings.push_back(
          {.kind = FindingKind::kBeyondLimit,
           .signal = "q",
           .joint = j,
           .begin_s = d.t[rows.front()],
           .end_s = d.t[rows.back()],
           .size = d.q(farthest, j),
           .unit = fmt::format("rad, limits {:.4g} and {:.4g} rad", joint.lower, joint.upper)});
  }
}

// Sizes of joints that slide are lengths and forces.
void name_units(const dynamics::RobotModel& robot, Findings& findings) {
  for (Finding& f : findings)
    if (f.joint >= 0)
      f.unit = unit_of_joint(f.unit, slides(robot.joints[static_cast<std::size_t>(f.joint)]));
}

}  // namespace

std::vector<Finding> diagnose(const data::Dataset& d, const dynamics::RobotModel* robot) {
  Findings findings;
  if (std::optional<Finding> disorder = find_out_of_order(d))
    findings.push_back(std::move(*disorder));
  else
    check_restarts(d, findings);
  if (findings.empty())
    if (const std::optional<Finding> in_turn = find_sources_in_turn(d)) return {*in_turn};
  if (findings.empty())
    if (std::optional<Finding> held = find_held(d)) findings.push_back(std::move(*held));
  if (!findings.empty()) {
    const FindingKind kind = findings[0].kind;
    if (kind == FindingKind::kRestart) return findings;
    const Findings others = diagnose(repair(d, findings, {{kind}}), robot);
    findings.insert(findings.end(), others.begin(), others.end());
    return findings;
  }
  check_clock(d, findings);
  check_signals(d, findings);
  if (robot != nullptr) know_limits(*robot, findings);
  join_missing(d, findings);
  know_what_is_left(d, findings);
  find_segments(d, findings);

  // The rest needs even times: what was found so far is mended for it, single wrong samples too.
  std::vector<FindingKind> mended;
  for (const FindingKind kind :
       {FindingKind::kJitter, FindingKind::kUneven, FindingKind::kClockDrift,
        FindingKind::kDuplicate, FindingKind::kGap, FindingKind::kSpike, FindingKind::kRepeated,
        FindingKind::kJump})
    if (std::ranges::any_of(findings,
                            [&](const Finding& f) { return f.kind == kind && can_be_repaired(f); }))
      mended.push_back(kind);
  data::Dataset even = mended.empty() ? d : repair(d, findings, mended);
  if (const std::optional<Finding> lost = find_lost_rows(even)) {
    // what moves on while a row is lost seems to slip
    std::erase_if(findings, [](const Finding& f) {
      return f.kind == FindingKind::kJump && !can_be_repaired(f);
    });
    findings.push_back(*lost);
  }
  for (data::RowMatrix* x : {&even.q, &even.tau, &even.v}) bridge(*x);
  for (const Finding& f : findings) {
    const bool slips = f.kind == FindingKind::kJump && !can_be_repaired(f);
    if (slips || f.kind == FindingKind::kSame || (f.kind == FindingKind::kStuck && f.signal != "v"))
      leave_out(f.signal == "q" ? even.q : even.tau, f, even.t);
  }
  const std::size_t before = findings.size();
  check_dynamics(even, robot, findings);
  std::vector<FindingKind> misnamed;
  for (std::size_t i = before; i < findings.size(); ++i) {
    const FindingKind kind = findings[i].kind;
    if (info_of(kind).fixable && kind != FindingKind::kDelay &&
        std::ranges::count(misnamed, kind) == 0)
      misnamed.push_back(kind);
  }
  check_velocity(misnamed.empty() ? even : repair(even, findings, misnamed), findings);
  if (robot != nullptr) {
    check_limits(even, *robot, findings);
    name_units(*robot, findings);
  }
  return findings;
}

std::vector<std::vector<Finding>> diagnose(std::span<const data::Dataset> logs,
                                           const dynamics::RobotModel* robot) {
  std::vector<std::vector<Finding>> of_logs;
  for (const data::Dataset& log : logs) of_logs.push_back(diagnose(log, robot));
  const auto still_in = [](const Findings& findings, int joint) {
    return std::ranges::any_of(findings, [joint](const Finding& f) {
      return f.kind == FindingKind::kStill && f.joint == joint;
    });
  };
  const std::vector<Findings> all = of_logs;
  for (Findings& findings : of_logs)
    std::erase_if(findings, [&](const Finding& f) {
      return f.kind == FindingKind::kStill && std::ranges::any_of(all, [&](const Findings& other) {
               return !still_in(other, f.joint);
             });
    });
  // one clock logged all: a few slow moves may seem to lead where most logs do not
  const auto leads = [](const Finding& f) {
    return f.kind == FindingKind::kDelayUnknown && f.size < 0;
  };
  const auto leading = std::ranges::count_if(
      all, [&](const Findings& findings) { return std::ranges::any_of(findings, leads); });
  if (2 * leading < std::ssize(all))
    for (Findings& findings : of_logs) std::erase_if(findings, leads);
  return of_logs;
}

}  // namespace fricid::doctor
