#include "fricid/estimate/remarks.hpp"

#include <string>

#include <fmt/format.h>

#include "fricid/base/text.hpp"
#include "support.hpp"

namespace fricid::estimate {
namespace {

constexpr double kUnresolved = 0.25;  // of a stiffness
constexpr double kWeak = 0.5;         // static friction over that of sliding

}  // namespace

std::vector<data::FittedRemark> remarks_on(std::span<const data::FittedJoint> joints,
                                           const friction::RobotFriction& friction) {
  std::vector<std::string> unresolved, weak;
  for (std::size_t j = 0; j < joints.size(); ++j) {
    const data::FittedJoint& joint = joints[j];
    const auto begin = static_cast<std::size_t>(friction.parameter_begin(static_cast<int>(j)));
    for (std::size_t i = 0; i < joint.parameters.size(); ++i) {
      const data::FittedParameter& parameter = joint.parameters[i];
      const friction::Role role = friction.parameters()[begin + i].info.role;
      if (role == friction::Role::kStiffness &&
          parameter.motion_error.value_or(0) > kUnresolved * parameter.value)
        unresolved.push_back(fmt::format("{} of {} by {:.0f} %", parameter.symbol, joint.joint,
                                         100 * *parameter.motion_error / parameter.value));
      const int sliding = coulomb_beside(friction, begin + i);
      if (role != friction::Role::kStatic || sliding < 0) continue;
      const double Fc = joint.parameters[static_cast<std::size_t>(sliding) - begin].value;
      if (parameter.value < kWeak * Fc)
        weak.push_back(fmt::format("{} ({} {:.2g} of {:.3g})", joint.joint, parameter.symbol,
                                   parameter.value, Fc));
    }
  }
  std::vector<data::FittedRemark> remarks;
  if (!unresolved.empty())
    remarks.push_back(
        {"presliding is not resolved: what the motion lost to its filter and between its samples "
         "may "
         "have changed " +
             enumeration(unresolved),
         "these stiffnesses are guesses, and with them how a joint starts, reverses and is held",
         "log at a higher rate, raise identify.cutoff_hz, or record slower reversals"});
  if (!weak.empty())
    remarks.push_back(
        {"static friction below half of that of sliding: " + enumeration(weak),
         "it is no break-away torque: friction falls towards rest where the law has no presliding, "
         "or "
         "another one than the joint, or where viscous friction is concave",
         "take break-away from a law with presliding that explains the torque better, or from slow "
         "reversals logged at a higher rate"});
  return remarks;
}

}  // namespace fricid::estimate
