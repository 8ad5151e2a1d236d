#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "fricid/base/not_finite.hpp"
#include "fricid/dynamics/nominal.hpp"
#include "fricid/estimate/fit.hpp"

namespace fricid::estimate {
namespace {

constexpr double kPoor = 0.5;       // R2 of a joint's training torque
constexpr double kSignificant = 4;  // standard errors
constexpr double kStill = 5e-3;     // [rad or m] of travel within which friction settles

/// Motion and torque of one joint in the training data.
struct Seen {
  double travel = 0;        // [rad or m]
  double torque_range = 0;  // [N m]
};

Seen look_at(std::span<const signals::Recording> sequences, int j) {
  double low = kInfinity, high = -kInfinity, least = kInfinity, most = -kInfinity;
  for (const signals::Recording& s : sequences) {
    low = std::min(low, s.narrow.q.col(j).minCoeff());
    high = std::max(high, s.narrow.q.col(j).maxCoeff());
    least = std::min(least, s.filtered_tau.col(j).minCoeff());
    most = std::max(most, s.filtered_tau.col(j).maxCoeff());
  }
  return {high - low, most - least};
}

/// What a fitted law says of friction that does not grow with speed.
struct Levels {
  double sum = 0;        ///< of Coulomb friction and of the elements' levels [N m]
  std::string at_upper;  ///< one that ended on its upper bound, "Fc = 1e+04 N m"; empty: none
};

/// Coulomb friction on its lower bound is no fault: the law then has none, or its static friction
/// stands for it and counts in its place.
Levels levels_of(const friction::RobotFriction& model, int joint, const JointFrictionFit& fit) {
  using enum friction::Role;
  Levels levels;
  const auto begin = static_cast<std::size_t>(model.parameter_begin(joint));
  double at_rest = 0;
  bool slides_freely = false;
  for (std::size_t i = 0; i < fit.theta.size(); ++i) {
    const friction::ParameterRef& parameter = model.parameters()[begin + i];
    const friction::ParameterInfo& info = parameter.info;
    const double value = fit.theta[i];
    if (info.role == kStatic) at_rest = value;
    if (info.role != kCoulomb && info.role != kLevel) continue;
    levels.sum += value;
    if (std::ranges::count(fit.at_bound, parameter.symbol) == 0) continue;
    const bool upper = value > (info.lower + info.upper) / 2;
    if (upper) levels.at_upper = fmt::format("{} = {:.3g} {}", parameter.symbol, value, info.unit);
    slides_freely |= !upper && info.role == kCoulomb;
  }
  if (slides_freely) levels.sum += at_rest;
  return levels;
}

std::string more_data(const Prepared& prepared) {
  return prepared.rigid_body.prior.empty()
             ? "record more and faster motion (`fricid check --design`), or set [identify.prior] "
               "use "
               "= true"
             : "record more and faster motion (`fricid check --design`)";
}

}  // namespace

std::string in_words(const Fault& fault) {
  return fmt::format("{}{}{}; {}", fault.joint, fault.joint.empty() ? "" : ": ", fault.found,
                     fault.remedy);
}

std::vector<Fault> faults_of(const Prepared& prepared, const FitReport& report) {
  std::vector<Fault> faults;
  const RigidBodyFit& rigid = report.rigid_body;
  if (rigid.outcome == Outcome::kIllConditioned || rigid.outcome == Outcome::kFailed)
    faults.push_back({"", "rigid body: " + rigid.message, more_data(prepared)});

  const friction::RobotFriction& friction = report.model.arm.friction.model;
  for (std::size_t i = 0; i < report.r2.size(); ++i) {
    const int j = static_cast<int>(i);
    const dynamics::Joint& joint = prepared.robot.joints[i];
    const Seen seen = look_at(prepared.recordings, j);
    const auto add = [&](std::string found, std::string remedy) {
      faults.push_back({joint.name, std::move(found), std::move(remedy)});
    };
    if (seen.travel < kStill) {
      add(fmt::format("moves by {:.2g} {} in all training data", seen.travel,
                      joint.type == dynamics::JointType::kRevolute ? "rad" : "m"),
          fmt::format("move it, or exclude it: [robot] hold = [\"{}\"]", joint.name));
      continue;
    }
    if (!std::isfinite(report.residual_rms[i]) && friction.reads_load())
      add("its torque has no finite value: friction grows with the load by more than the load",
          "leave what grows with the load out of the laws of the model; " + more_data(prepared));
    else if (!(report.r2[i] >= kPoor))
      add(fmt::format("R2 {:.3g} on its own training torque", report.r2[i]),
          fmt::format(
              "{}look for a wrong sign, unit or delay (`fricid check`), a load or coupling "
              "missing in the robot's file; {}",
              std::ranges::count(prepared.options.guesses.armature, j) > 0
                  ? fmt::format(
                        "state its armature, robot.armature = {{{} = {:.2g}}} was guessed; ",
                        joint.name, prepared.robot.pi[prepared.robot.armature_begin() + j])
                  : "",
              more_data(prepared)));
    if (i < report.couplings.size() && matters(report.couplings[i], report.r2[i]))
      add(fmt::format("friction depends on the speed of {} too ({:.0f} % of the residual)",
                      name_of_other(report.couplings[i], prepared.robot),
                      100 * report.couplings[i].share),
          fmt::format("a coupled wrist, differential or belt: declare it, {}, or use only the "
                      "other joints",
                      declaration_of(report.couplings[i], j, prepared.robot)));
    if (i >= report.joints.size()) continue;
    const JointFrictionFit& fit = report.joints[i];
    const auto& [level, at_upper] = levels_of(friction, j, fit);
    if (level > seen.torque_range)
      add(fmt::format("friction of {:.3g} N m, while its torque ranged over {:.3g} N m", level,
                      seen.torque_range),
          more_data(prepared));
    else if (joint.effort > 0 && level > joint.effort)
      add(fmt::format("friction of {:.3g} N m, above its effort limit {:.3g} N m", level,
                      joint.effort),
          "look for a wrong torque unit (`fricid check`)");
    else if (!at_upper.empty())
      add(fmt::format("{} ended on the upper bound of its law", at_upper), more_data(prepared));
    else if (prepared.rigid_body.Fc_beside.size() > j &&
             prepared.rigid_body.Fc_beside[j] < -kSignificant * prepared.rigid_body.Fc_se[j])
      add(fmt::format("Coulomb friction came out negative, {:.2g} +- {:.1g} N m",
                      prepared.rigid_body.Fc_beside[j], prepared.rigid_body.Fc_se[j]),
          "look for a wrong sign or delay (`fricid check`); " + more_data(prepared));
    if (fit.outcome == Outcome::kFailed) add("friction: " + fit.message, more_data(prepared));
  }
  return faults;
}

}  // namespace fricid::estimate
