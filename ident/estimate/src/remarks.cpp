#include "fricid/estimate/remarks.hpp"

#include <cmath>
#include <numbers>
#include <string>

#include <fmt/format.h>

#include "fricid/base/text.hpp"
#include "fricid/base/unit_of_joint.hpp"
#include "support.hpp"

namespace fricid::estimate {
namespace {

constexpr double kUnresolved = 0.25;    // of a stiffness
constexpr double kMost = 1;             // of a stiffness: beyond, how much is unknown
constexpr double kWeak = 0.5;           // static friction over that of sliding
constexpr double kBreaksAway = 1.1;     // the same of a break-away torque
constexpr double kExplained = 0.2;      // share of a residual that is worth a word
constexpr double kBends = 0.4;          // the same of a bend, which load may look like
constexpr double kWorthBending = 0.02;  // of the largest torque
constexpr double kMostBending = 0.6;    // of it: more is no torque constant

}  // namespace

std::vector<data::FittedRemark> remarks_on(std::span<const data::FittedJoint> joints,
                                           const friction::RobotFriction& friction,
                                           std::span<const PositionWave> waves,
                                           std::span<const TorqueBend> bends,
                                           std::span<const TightSpot> spots) {
  std::vector<std::string> unresolved, weak, narrow, guessed, of_position, tight, bent;
  for (std::size_t j = 0; j < joints.size(); ++j) {
    const data::FittedJoint& joint = joints[j];
    const auto begin = static_cast<std::size_t>(friction.parameter_begin(static_cast<int>(j)));
    double beside = 0;  // Stribeck torques of the speed alone
    for (std::size_t i = 0; i < joint.parameters.size(); ++i)
      if (friction.parameters()[begin + i].info.role == friction::Role::kStatic &&
          coulomb_beside(friction, begin + i) < 0)
        beside += joint.parameters[i].value;
    for (std::size_t i = 0; i < joint.parameters.size(); ++i) {
      const data::FittedParameter& parameter = joint.parameters[i];
      const friction::Role role = friction.parameters()[begin + i].info.role;
      if (role == friction::Role::kStiffness &&
          parameter.motion_error.value_or(0) > kUnresolved * parameter.value)
        unresolved.push_back(
            *parameter.motion_error > kMost * parameter.value
                ? fmt::format("{} of {} by more than itself", parameter.symbol, joint.joint)
                : fmt::format("{} of {} by {:.0f} %", parameter.symbol, joint.joint,
                              100 * *parameter.motion_error / parameter.value));
      if (std::ranges::count(joint.guessed, parameter.symbol) > 0)
        guessed.push_back(
            fmt::format("{} of {} ({:.3g})", parameter.symbol, joint.joint, parameter.value));
      const int sliding = coulomb_beside(friction, begin + i);
      if (role != friction::Role::kStatic || sliding < 0) continue;
      const double Fc = joint.parameters[static_cast<std::size_t>(sliding) - begin].value;
      const auto is_at_bound = [&](const data::FittedParameter& other) {
        return std::ranges::count(joint.at_bound, other.symbol) > 0;
      };
      for (std::size_t k = 0; k < joint.parameters.size(); ++k)
        if (const friction::ParameterRef& other = friction.parameters()[begin + k];
            other.info.role == friction::Role::kStribeckVelocity &&
            other.law == friction.parameters()[begin + i].law && is_at_bound(joint.parameters[k]) &&
            parameter.value > kBreaksAway * Fc)
          narrow.push_back(fmt::format("{} of {} ({} on its least, {:.2g} rad/s)", parameter.symbol,
                                       joint.joint, joint.parameters[k].symbol,
                                       joint.parameters[k].value));
      if (parameter.value + beside < kWeak * Fc)
        weak.push_back(fmt::format("{} ({} {:.2g} of {:.3g})", joint.joint, parameter.symbol,
                                   parameter.value, Fc));
    }
  }
  for (std::size_t j = 0; j < waves.size(); ++j)
    if (waves[j].share > kExplained)
      of_position.push_back(
          fmt::format("{} ({:.0f} % by {})", joints[j].joint, 100 * waves[j].share,
                      waves[j].slides ? fmt::format("waves of {:.3g} mm, N = {:.4g}",
                                                    2e3 * std::numbers::pi / waves[j].n, waves[j].n)
                                      : fmt::format("{:.4g} periods per turn", waves[j].n)));
  for (std::size_t j = 0; j < spots.size(); ++j)
    if (spots[j].share > kExplained)
      tight.push_back(fmt::format("{} ({:.0f} %, most at {:.3g} {}, {:+.3g} {})", joints[j].joint,
                                  100 * spots[j].share, spots[j].at,
                                  unit_of_joint("rad", spots[j].slides), spots[j].more,
                                  unit_of_joint("N m", spots[j].slides)));
  for (std::size_t j = 0; j < bends.size(); ++j)
    if (const double size = std::abs(bends[j].at_largest);
        bends[j].share > kBends && size > kWorthBending && size < kMostBending)
      bent.push_back(fmt::format("{} ({:.0f} % by {:+.2g} % at the largest torque)",
                                 joints[j].joint, 100 * bends[j].share, 100 * bends[j].at_largest));
  std::vector<data::FittedRemark> remarks;
  if (!unresolved.empty())
    remarks.push_back(
        {"presliding is not resolved: what the motion lost to its filter and between its samples "
         "may have changed " +
             enumeration(unresolved),
         "these stiffnesses are guesses, and with them how a joint starts, reverses and is held",
         "log at a higher rate, raise identify.cutoff_hz, or record slower reversals"});
  if (!weak.empty())
    remarks.push_back(
        {"static friction below half of that of sliding: " + enumeration(weak),
         "it is no break-away torque: friction falls towards rest where the law has no presliding, "
         "or another one than the joint, or where viscous friction is concave",
         "take break-away from a law with presliding that explains the torque better, or from slow "
         "reversals logged at a higher rate"});
  if (!narrow.empty())
    remarks.push_back({"break-away torque is not resolved: " + enumeration(narrow),
                       "friction falls within less speed than that; the true break-away torque is "
                       "larger",
                       "log slow reversals at a higher rate and raise identify.cutoff_hz"});
  if (!guessed.empty())
    remarks.push_back(
        {"static friction is not seen: " + enumeration(guessed) + ", twice that of sliding",
         "what would explain the torque best is larger than any torque; break-away, and how the "
         "joint starts and reverses in open loop, are a guess",
         "record rests and slow reversals, or take dahl or the lvm"});
  if (!of_position.empty())
    remarks.push_back({"what is left of the torque goes with the joint's own position: " +
                           enumeration(of_position),
                       "no law of friction has a torque that does not change sign with the speed, "
                       "as of cogging, and open loops go astray by it",
                       "declare it: [[robot.torque]] with terms = [\"sin(N q)\", \"cos(N q)\"]"});
  if (!tight.empty())
    remarks.push_back(
        {"what is left of the torque is friction at places of the joint's travel: " +
             enumeration(tight),
         "a tight spot, as of a bent shaft, a worn tooth or a cable that rubs, is in no "
         "law; inertia and friction of the joint are fitted to it",
         "mend the joint, or leave that place out of the motion"});
  if (!bent.empty())
    remarks.push_back(
        {"what laws of friction leave of the torque bends with the torque: " + enumeration(bent),
         "as of a motor whose torque constant falls with the current: bodies and "
         "friction are off by a good part of that",
         "correct the logged torque by the curve of the motor, or move more slowly"});
  return remarks;
}

}  // namespace fricid::estimate
