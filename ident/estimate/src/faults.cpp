#include <algorithm>
#include <cmath>
#include <iterator>

#include <fmt/format.h>

#include "fricid/base/not_finite.hpp"
#include "fricid/base/unit_of_joint.hpp"
#include "fricid/dynamics/nominal.hpp"
#include "fricid/estimate/fit_report.hpp"
#include "rigid_body/joint_inertia.hpp"
#include "support.hpp"

namespace fricid::estimate {
namespace {

constexpr double kPoor = 0.5;            // R2 of a joint's training torque
constexpr double kSignificant = 4;       // standard errors
constexpr double kWellExplained = 0.99;  // R2
constexpr double kMostStatic = 2;     // static over Coulomb friction, which holds a joint at rest
constexpr double kContradicts = 2.5;  // residual under a prior, times that of the data alone
constexpr double kStill = 5e-3;       // [rad or m] of travel within which friction settles
constexpr double kChatters = 0.05;    // of the seconds of the recordings
constexpr double kLeastOfArmature = 0.5;  // inertia over the armature that is stated
constexpr double kMostOfFile = 5;         // times the robot's file; usual armatures hold within 4
constexpr double kFaster = 1.5;           // speed over that of the sliding that counts
constexpr double kSlow = 0.2;             // [rad/s] up to which friction may fall with the speed
constexpr double kConstant = 1e-9;        // range of a torque, over its size, that is rounding

/// Motion and torque of one joint in the training data.
struct Seen {
  double travel = 0;        // [rad or m]
  double speed = 0;         // the largest [rad/s or m/s]
  double torque_range = 0;  // [N m]
  double torque = 0;        // the largest
};

Seen look_at(std::span<const signals::Recording> sequences, int j) {
  double low = kInfinity, high = -kInfinity, least = kInfinity, most = -kInfinity, speed = 0;
  for (const signals::Recording& s : sequences) {
    low = std::min(low, s.narrow.q.col(j).minCoeff());
    high = std::max(high, s.narrow.q.col(j).maxCoeff());
    speed = std::max(speed, s.narrow.v.col(j).cwiseAbs().maxCoeff());
    least = std::min(least, s.filtered_tau.col(j).minCoeff());
    most = std::max(most, s.filtered_tau.col(j).maxCoeff());
  }
  return {high - low, speed, most - least, std::max(std::abs(least), std::abs(most))};
}

/// Seconds of the recordings in which a joint turns to and fro faster than any motion that was
/// meant: 30 times or more, each time through speeds that its encoder sees.
struct Chatter {
  int seconds = 0, of = 0;
  int reversals = 0;  // in the worst of them
};

Chatter chatter_of(const Prepared& prepared, int j) {
  constexpr int kMost = 30;
  const double visible =
      smoothing_speed(prepared.robot, prepared.recordings, prepared.options.cutoff_hz, j);
  Chatter found;
  for (const signals::Recording& r : prepared.recordings) {
    const int second = std::max(1, static_cast<int>(std::lround(1 / r.dt)));
    for (int begin = 0; begin + second <= r.length(); begin += second) {
      const int reversals = reversals_in(r.wide.v.col(j).segment(begin, second), visible);
      ++found.of;
      found.seconds += reversals >= kMost;
      found.reversals = std::max(found.reversals, reversals);
    }
  }
  return found;
}

/// Greatest friction at low speed that the laws of a joint have there [N m]: of each law the sum of
/// Coulomb friction and of the elements' levels, or its static friction where that is more. A
/// spring that the travel does not load to its level counts by what it holds.
double friction_level(const friction::Friction& friction, int joint, double travel) {
  using enum friction::Role;
  const std::vector<friction::ParameterRef>& parameters = friction.model.parameters();
  const auto begin = static_cast<std::size_t>(friction.model.parameter_begin(joint)),
             end = static_cast<std::size_t>(friction.model.parameter_begin(joint + 1));
  const auto stiffness = [&](const friction::ParameterRef& level) {
    for (std::size_t i = begin; i < end; ++i)
      if (parameters[i].law == level.law && parameters[i].info.role == kStiffness &&
          parameters[i].symbol.substr(1) == level.symbol.substr(1))
        return friction.theta[i];
    return kInfinity;
  };
  std::vector<double> sliding, at_rest;
  for (std::size_t i = begin; i < end; ++i) {
    const auto law = static_cast<std::size_t>(parameters[i].law);
    if (law >= sliding.size()) sliding.resize(law + 1), at_rest.resize(law + 1);
    const double value = friction.theta[i];
    if (parameters[i].info.role == kCoulomb) sliding[law] += value;
    if (parameters[i].info.role == kLevel)
      sliding[law] += std::min(value, stiffness(parameters[i]) * travel);
    if (parameters[i].info.role == kStatic) at_rest[law] += value;
  }
  double level = 0;
  for (std::size_t law = 0; law < sliding.size(); ++law)
    level += std::max(sliding[law], at_rest[law]);
  return level;
}

/// A torque of a joint's laws that ended on the upper bound of its range, or Coulomb friction on a
/// lower one, "Fc = 1e-06 N m ended on the lower bound of its law"; empty: none. A lower bound that
/// is next to nothing beside the torque of the joint is no fault: the law then has no Coulomb
/// friction, or its static friction stands for it.
std::string torque_at_bound(const friction::Friction& friction, int joint, bool slides,
                            double torque_range) {
  using enum friction::Role;
  constexpr double kNothing = 0.01;  // of the joint's torque
  constexpr double kNear = 2e-3;     // of the bound: where a search ends
  const std::vector<friction::ParameterRef>& parameters = friction.model.parameters();
  const auto begin = static_cast<std::size_t>(friction.model.parameter_begin(joint)),
             end = static_cast<std::size_t>(friction.model.parameter_begin(joint + 1));
  for (std::size_t i = begin; i < end; ++i) {
    const friction::ParameterInfo& info = parameters[i].info;
    if (info.role != kCoulomb && info.role != kStatic && info.role != kLevel) continue;
    const double value = friction.theta[i];
    const bool upper = value >= info.upper * (1 - kNear),
               lower = info.role == kCoulomb && value <= info.lower * (1 + kNear) &&
                       info.lower > kNothing * torque_range;
    if (upper || lower)
      return fmt::format("{} = {:.3g} {} ended on the {} bound of its law", parameters[i].symbol,
                         value, unit_of_joint(info.unit, slides), upper ? "upper" : "lower");
  }
  return {};
}

std::string more_data(const Prepared& prepared) {
  return prepared.rigid_body.prior.empty()
             ? "record more and faster motion (`fricid check --design`), or set [identify.prior] "
               "use "
               "= true"
             : "record more and faster motion (`fricid check --design`)";
}

/// What to do about a joint whose torque is not explained.
std::string remedy_of_torque(const Prepared& prepared, int j) {
  const bool guessed = std::ranges::count(prepared.options.guesses.armature, j) > 0;
  return fmt::format(
      "{}look for a wrong sign, unit or delay (`fricid check`), a load or coupling missing in the "
      "robot's file; {}",
      guessed ? fmt::format("state its armature, robot.armature = {{{} = {:.2g}}} was guessed; ",
                            prepared.robot.joints[static_cast<std::size_t>(j)].name,
                            prepared.robot.pi[prepared.robot.armature_begin() + j])
              : "",
      more_data(prepared));
}

/// What is wrong with the torque that a model gives a joint; `found` empty: nothing.
Fault fault_of_torque(const Prepared& prepared, const FitReport& report, int j, const Seen& seen) {
  const auto i = static_cast<std::size_t>(j);
  const std::string& name = prepared.robot.joints[i].name;
  const bool finite = std::isfinite(report.residual_rms[i]);
  if (!finite && report.model.arm.friction.model.reads_load())
    return {name,
            "its torque has no finite value: friction grows with the load by more than the load",
            "leave what grows with the load out of the laws of the model; " + more_data(prepared)};
  if (!finite) return {name, "its torque has no finite value", more_data(prepared)};
  if (seen.torque_range <= kConstant * seen.torque)
    return {
        name, "its training torque does not vary",
        fmt::format("log the torque of its motor, or exclude it: [robot] hold = [\"{}\"]", name)};
  if (report.r2[i] >= kPoor) return {};
  std::string found = fmt::format("R2 {:.3g} on its own training torque", report.r2[i]);
  const bool off_at_rest_alone = report.sliding_r2[i] >= kPoor &&
                                 report.resting_rms[i] < kMostStatic * prepared.rigid_body.Fc[j];
  if (!off_at_rest_alone) return {name, std::move(found), remedy_of_torque(prepared, j)};
  // a joint that rests is held by any torque within its friction, which no model can know
  if (report.r2[i] >= 0) return {};
  found += fmt::format(
      ", worse than its mean: while the joint slides it is explained (R2 {:.3g}), where it rests "
      "{:.3g} {} of what holds it are not",
      report.sliding_r2[i], report.resting_rms[i],
      unit_of_joint("N m", slides(prepared.robot.joints[i])));
  return {name, std::move(found),
          "leave its rests out (train = [\"log.csv[FROM:TO]\"]), let it move more of the time, or "
          "take a law that holds a joint at rest (dahl, gms)"};
}

std::string remedy_of_coupling(const std::string& declaration) {
  const std::string what = "a coupled wrist, differential or belt";
  return declaration.empty()
             ? what +
                   " with friction at its motors and at its joints, of which a model has one: use "
                   "the values of the other joints alone"
             : fmt::format("{}: declare it, {}, or use the values of the other joints alone", what,
                           declaration);
}

/// What to do about viscous friction below zero.
std::string remedy_of_viscous(const Prepared& prepared, const dynamics::Joint& joint,
                              const Seen& seen) {
  const std::string look = "look for a wrong mount, sign, delay or coupling (`fricid check`)";
  const double slow = kSlow * dynamics::travel_scale(joint);
  if (seen.speed > slow) return look + "; " + more_data(prepared);
  const std::string unit = unit_of_joint("rad/s", slides(joint));
  return fmt::format(
      "speeds below {:.2g} {} lie on the falling part of the Stribeck curve: record faster motion, "
      "the fastest was {:.2g} {}; or {}",
      slow, unit, seen.speed, unit, look);
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
  const bool has_temperature = std::ranges::any_of(friction.parameters(), [](const auto& p) {
    return p.info.role == friction::Role::kTemperatureCoefficient;
  });
  std::ranges::copy_if(prepared.contradictions, std::back_inserter(faults),
                       [&](const Fault& f) { return !(f.without_temperature && has_temperature); });

  const Eigen::VectorXd& prior_alone = prepared.rigid_body.sigma_alone;
  const Eigen::VectorXd usual = joint_inertia(prepared.robot, prepared.recordings),
                        inertia = joint_inertia(report.model.arm.robot, prepared.recordings);
  const bool beyond_gear = is_beyond_gear(prepared.recordings);
  for (std::size_t i = 0; i < report.r2.size(); ++i) {
    const int j = static_cast<int>(i);
    const dynamics::Joint& joint = prepared.robot.joints[i];
    const Seen seen = look_at(prepared.recordings, j);
    const std::string torque = unit_of_joint("N m", slides(joint));
    const bool guessed = std::ranges::count(prepared.options.guesses.armature, j) > 0;
    const auto add = [&](std::string found, std::string remedy) {
      faults.push_back({joint.name, std::move(found), std::move(remedy)});
    };
    const bool one_speed = prepared.rigid_body.moves_at_one_speed(j);
    if (seen.travel < kStill) {
      add(fmt::format("moves by {:.2g} {} in all training data", seen.travel,
                      joint.type == dynamics::JointType::kRevolute ? "rad" : "m"),
          fmt::format("move it, or exclude it: [robot] hold = [\"{}\"]", joint.name));
      continue;
    }
    if (const Chatter chatter = chatter_of(prepared, j); chatter.seconds > kChatters * chatter.of)
      add(fmt::format("its measured motion chatters in {} of {} s: up to {} reversals in a second",
                      chatter.seconds, chatter.of, chatter.reversals),
          "friction is not that of a motion that reverses between its samples: mend the "
          "controller, "
          "or leave that time out");
    if (one_speed) {
      const signals::SpeedRange& range = prepared.rigid_body.speeds[i];
      const std::string unit = unit_of_joint("rad/s", slides(joint));
      const bool reverses = seen.speed > kFaster * range.fast;
      add(fmt::format("slides at one speed{}, {:.2g} to {:.2g} {}: Coulomb and viscous friction "
                      "cannot be told apart",
                      reverses ? " where it has forgotten its last reversal" : "", range.slow,
                      range.fast, unit),
          reverses
              ? fmt::format("record longer moves at other speeds (`fricid check --design`): the "
                            "moves at up to {:.2g} {} reverse too often",
                            seen.speed, unit)
              : "record other speeds too (`fricid check --design`)");
    }
    if (Fault fault = fault_of_torque(prepared, report, j, seen); !fault.found.empty())
      faults.push_back(std::move(fault));
    if (i < report.couplings.size() && matters(report.couplings[i], report.r2[i]))
      add(fmt::format("friction depends on the speed of {} too ({:.0f} % of the residual)",
                      name_of_other(report.couplings[i], prepared.robot),
                      100 * report.couplings[i].share),
          remedy_of_coupling(declaration_of(report.couplings[i], j, prepared.robot)));
    if (prior_alone.size() > j && prepared.rigid_body.sigma[j] > kContradicts * prior_alone[j])
      add(fmt::format(
              "[identify.prior] contradicts its torque: it leaves {:.3g} {}, the data alone "
              "{:.3g}",
              prepared.rigid_body.sigma[j], torque, prior_alone[j]),
          "mend what the robot's file says of its inertia (an armature is the rotor's inertia "
          "times "
          "the square of the ratio; a counterweight is a mass), widen the prior, or fit without "
          "it");
    // without limits a usual armature is that of the links, and a rotor may be any times as much
    const bool rotor_unknown = guessed && !(joint.velocity > 0 && joint.effort > 0);
    if (inertia[j] > kMostOfFile * usual[j] && !rotor_unknown)
      add(fmt::format(
              "inertia of {:.3g} {}, {:.0f} times that of the robot's file with {} armature",
              inertia[j], joint.type == dynamics::JointType::kRevolute ? "kg m^2" : "kg",
              inertia[j] / usual[j], guessed ? "a usual" : "its"),
          (guessed ? fmt::format("state its armature, robot.armature = {{{} = ...}}; ", joint.name)
                   : "") +
              more_data(prepared));
    const double armature = prepared.robot.pi[prepared.robot.armature_begin() + j];
    if (!guessed && !beyond_gear && inertia[j] < kLeastOfArmature * armature)
      add(fmt::format("inertia of {:.3g} {}, less than half of the armature alone that is stated "
                      "for it, {:.3g}",
                      inertia[j], unit_of_joint("kg m^2", slides(joint)), armature),
          "correct the armature in the robot's file, or look for a delay (`fricid check`); "
          "friction "
          "that no law describes, as of a spring that relaxes, looks like less inertia too");
    // a law that explains the torque need not have the sign of a straight line through its curve
    const bool bears_regression =
        !beyond_gear && (is_linear(friction, j) || !(report.r2[i] > kWellExplained));
    const double level = friction_level(report.model.arm.friction, j, seen.travel);
    std::string at_bound =
        torque_at_bound(report.model.arm.friction, j, slides(joint), seen.torque_range);
    if (level > seen.torque_range)
      add(fmt::format("friction of {:.3g} {}, while its torque ranged over {:.3g} {}", level,
                      torque, seen.torque_range, torque),
          more_data(prepared));
    else if (joint.effort > 0 && level > joint.effort)
      add(fmt::format("friction of {:.3g} {}, above its effort limit {:.3g} {}", level, torque,
                      joint.effort, torque),
          "look for a wrong torque unit (`fricid check`)");
    else if (!at_bound.empty())
      add(std::move(at_bound), more_data(prepared));
    else if (!one_speed && bears_regression && prepared.rigid_body.Fc_beside.size() > j &&
             prepared.rigid_body.Fc_beside[j] < -kSignificant * prepared.rigid_body.Fc_se[j])
      add(fmt::format("Coulomb friction came out negative, {:.2g} +- {:.1g} {}",
                      prepared.rigid_body.Fc_beside[j], prepared.rigid_body.Fc_se[j], torque),
          "look for a wrong sign or delay (`fricid check`); " + more_data(prepared));
    if (!one_speed && bears_regression && prepared.rigid_body.Fv_beside.size() > j &&
        prepared.rigid_body.Fv_beside[j] < -kSignificant * prepared.rigid_body.Fv_se[j])
      add(fmt::format("viscous friction came out negative, {:.2g} +- {:.1g} {}",
                      prepared.rigid_body.Fv_beside[j], prepared.rigid_body.Fv_se[j],
                      unit_of_joint("N m s/rad", slides(joint))),
          remedy_of_viscous(prepared, joint, seen));
    if (i < report.joints.size() && report.joints[i].outcome == Outcome::kFailed)
      add("friction: " + report.joints[i].message, more_data(prepared));
  }
  return faults;
}

}  // namespace fricid::estimate
