// Positions in degrees or millimetres.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "explained.hpp"
#include "hypothesis.hpp"

namespace fricid::doctor {
namespace {

constexpr double kDegree = std::numbers::pi / 180;

// Whether the logged velocity is that of a position in degrees, in radians.
bool velocity_tells_degrees(const data::Dataset& d, const Motion& motion, int j) {
  if (d.v.size() == 0) return false;
  const auto [dot, square, logged] = compare_velocity(motion, j, [&](int k) { return d.v(k, j); });
  return dot > 0.5 * kDegree * square && dot < 2 * kDegree * square &&
         dot * dot > 0.5 * square * logged;
}

/// Sliding joints far outside their limits: not in metres.
void check_lengths(const data::Dataset& d, const dynamics::RobotModel* robot, const Sight& sight,
                   Findings& findings) {
  constexpr double kFarOut = 2, kAnyway = 0.1;  // of the largest limit, [m]
  if (!robot) return;
  for (int j = 0; j < d.n(); ++j) {
    const dynamics::Joint& joint = robot->joints[static_cast<std::size_t>(j)];
    if (!slides(joint) || joint.upper <= joint.lower) continue;
    const double largest = sight.q.col(j).cwiseAbs().maxCoeff();
    if (largest <= kFarOut * std::max(std::abs(joint.lower), std::abs(joint.upper)) + kAnyway)
      continue;
    findings.push_back({.kind = FindingKind::kLengthUnit,
                        .signal = "q",
                        .joint = j,
                        .begin_s = d.t[0],
                        .end_s = d.t[d.length() - 1],
                        .size = largest,
                        .unit = fmt::format("m at most, as it stands, limits {:g} and {:g} m",
                                            joint.lower, joint.upper)});
  }
}

}  // namespace

// Positions far outside the limits, unless the torque contradicts it, or beyond two turns either
// way, are degrees. A continuous joint may turn: there degrees must explain more of the torque, or
// the velocity must say so.
void undo_degrees(const data::Dataset& d, const dynamics::RobotModel* robot, const Motion& motion,
                  Sight& sight, Findings& findings) {
  constexpr double kTwoTurns = 4 * std::numbers::pi;
  Findings found;
  const auto gain_of = [&](const Sight& undone) {
    Judge judge(robot, d.n());
    return gain(judge.explain(sight), judge.explain(undone));
  };
  for (int j = 0; j < d.n(); ++j) {
    const double largest = sight.q.col(j).cwiseAbs().maxCoeff();
    double allowed = kTwoTurns;
    if (robot) {
      const dynamics::Joint& joint = robot->joints[static_cast<std::size_t>(j)];
      if (slides(joint) || joint.continuous) continue;
      if (joint.upper > joint.lower)
        allowed = 1.3 * std::max(std::abs(joint.lower), std::abs(joint.upper)) + 0.5;
    }
    if (largest <= allowed) continue;
    const Hypothesis degrees{FindingKind::kAngleUnit, true, false, j, -1, kDegree};
    Sight undone = degrees.undone(sight);
    // within two turns the limits may be nobody's, and the torque tells
    if (robot && largest <= kTwoTurns && gain_of(undone) < 0) continue;
    sight = std::move(undone);
    found.push_back(describe(d, motion, degrees, largest, "rad at most, as it stands"));
  }
  for (int j = 0; robot && j < d.n(); ++j) {
    const dynamics::Joint& joint = robot->joints[static_cast<std::size_t>(j)];
    const double largest = sight.q.col(j).cwiseAbs().maxCoeff();
    if (slides(joint) || !joint.continuous || largest <= kTwoTurns) continue;
    const Hypothesis degrees{FindingKind::kAngleUnit, true, false, j, -1, kDegree};
    Sight undone = degrees.undone(sight);
    if (!velocity_tells_degrees(d, motion, j) && gain_of(undone) <= kBelief) continue;
    sight = std::move(undone);
    found.push_back(describe(d, motion, degrees, largest, "rad at most, as it stands"));
  }
  check_lengths(d, robot, sight, findings);
  // What is in degrees for most joints is so for all: a joint that moves little gives no sign of
  // it.
  if (static_cast<int>(found.size()) * 2 > d.n() && d.n() > 1) {
    for (int j = 0; j < d.n(); ++j) {
      const bool done =
          std::any_of(found.begin(), found.end(), [j](const Finding& f) { return f.joint == j; });
      const bool turns = !robot || robot->joints[static_cast<std::size_t>(j)].type ==
                                       dynamics::JointType::kRevolute;
      if (done || !turns) continue;
      sight =
          Hypothesis{FindingKind::kAngleUnit, true, false, j, -1, kDegree}.undone(std::move(sight));
      found.push_back(found.front());
      found.back().joint = j;
    }
    std::sort(found.begin(), found.end(),
              [](const Finding& a, const Finding& b) { return a.joint < b.joint; });
  }
  findings.insert(findings.end(), found.begin(), found.end());
}

}  // namespace fricid::doctor
