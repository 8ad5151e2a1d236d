#include <algorithm>
#include <cmath>
#include <limits>

#include <fmt/format.h>

#include "fricid/dynamics/nominal.hpp"
#include "fricid/estimate/fit.hpp"

namespace fricid::estimate {
namespace {

constexpr double kPoor = 0.5;    // R2 of a joint's training torque
constexpr double kStill = 5e-3;  // [rad or m] of travel within which friction settles

/// What the training data show of one joint.
struct Seen {
  double travel = 0;        // [rad or m]
  double torque_range = 0;  // [N m]
};

Seen look_at(std::span<const Filtered> sequences, int j) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  double low = kInfinity, high = -kInfinity, least = kInfinity, most = -kInfinity;
  for (const Filtered& s : sequences) {
    low = std::min(low, s.q.col(j).minCoeff());
    high = std::max(high, s.q.col(j).maxCoeff());
    least = std::min(least, s.tau.col(j).minCoeff());
    most = std::max(most, s.tau.col(j).maxCoeff());
  }
  return {high - low, most - least};
}

/// Friction of the parts of a fitted law that do not grow with speed: sum of its levels [N m].
double level_of(const friction::RobotFriction& model, int joint, const std::vector<double>& theta) {
  using enum friction::Role;
  double level = 0;
  const auto begin = static_cast<std::size_t>(model.parameter_begin(joint));
  for (std::size_t i = 0; i < theta.size(); ++i)
    if (const friction::Role role = model.parameters()[begin + i].info.role;
        role == kCoulomb || role == kLevel)
      level += theta[i];
  return level;
}

constexpr const char* kMoreData =
    "record more and faster motion (`fricid check --design`), or set [identify.prior] use = true";

}  // namespace

std::string in_words(const Fault& fault) {
  return fmt::format("{}{}{}; {}", fault.joint, fault.joint.empty() ? "" : ": ", fault.found,
                     fault.remedy);
}

std::vector<Fault> faults_of(const Prepared& prepared, const FitReport& report) {
  std::vector<Fault> faults;
  const RigidBodyFit& rigid = report.rigid_body;
  if (rigid.outcome == Outcome::kIllConditioned || rigid.outcome == Outcome::kFailed)
    faults.push_back({"", "rigid body: " + rigid.message, kMoreData});

  const friction::RobotFriction& friction = report.model.arm.friction.model;
  for (std::size_t i = 0; i < report.r2.size(); ++i) {
    const int j = static_cast<int>(i);
    const dynamics::Joint& joint = prepared.robot.joints[i];
    const Seen seen = look_at(prepared.sequences, j);
    const auto add = [&](std::string found, std::string remedy) {
      faults.push_back({joint.name, std::move(found), std::move(remedy)});
    };
    if (seen.travel < kStill) {
      add(fmt::format("moves by {:.2g} {} in all training data", seen.travel,
                      joint.type == dynamics::JointType::kRevolute ? "rad" : "m"),
          "move it, or weld it in the URDF (type=\"fixed\") and leave it out of the contract");
      continue;
    }
    if (!(report.r2[i] >= kPoor))
      add(fmt::format("R2 {:.3g} on its own training torque", report.r2[i]),
          fmt::format(
              "{}look for a wrong sign, unit or delay (`fricid check`), a load or coupling "
              "that the robot's file lacks; {}",
              prepared.robot.pi[prepared.robot.armature_begin() + j] == 0
                  ? fmt::format("state its armature in the URDF (<fricid armature=\"{:.2g}\"/>"
                                " would be usual); ",
                                dynamics::usual_armature(prepared.robot)[j])
                  : "",
              kMoreData));
    if (i >= report.joints.size()) continue;
    const JointFrictionFit& fit = report.joints[i];
    const double level = level_of(friction, j, fit.theta);
    if (level > seen.torque_range)
      add(fmt::format("friction of {:.3g} N m, while its torque ranged over {:.3g} N m", level,
                      seen.torque_range),
          kMoreData);
    else if (joint.effort > 0 && level > joint.effort)
      add(fmt::format("friction of {:.3g} N m, above its effort limit {:.3g} N m", level,
                      joint.effort),
          "look for a wrong torque unit (`fricid check`)");
    if (fit.outcome == Outcome::kFailed) add("friction: " + fit.message, kMoreData);
  }
  return faults;
}

}  // namespace fricid::estimate
