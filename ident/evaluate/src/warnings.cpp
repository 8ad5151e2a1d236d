#include "fricid/evaluate/warnings.hpp"

#include <algorithm>
#include <optional>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "fricid/base/text.hpp"

namespace fricid::evaluate {
namespace {

constexpr double kPoorCondition = 100;    // of the regression's columns, scaled to unit length
constexpr double kStartsDisagree = 1.05;  // worst start over best, in RMS
constexpr double kFewRows = 0.5;          // share of the recording

using Warnings = std::vector<Warning>;

void warn_of_trust(const data::FitFile& fit, const std::string& name, Warnings& warnings) {
  for (const data::FittedFault& fault : fit.faults)
    warnings.push_back({name + (fault.joint.empty() ? "" : ", ") + fault.joint, fault.found,
                        "the fit is not to be trusted", fault.remedy});
  if (const std::string& prior = fit.rigid_body.prior; !prior.empty() && prior != "asked for")
    warnings.push_back({name, "the robot's nominal values entered as a prior: " + prior,
                        "the data alone do not determine the rigid body",
                        "record more and faster motion, or state good nominal values"});
  for (const data::HeldArmature& held : fit.rigid_body.held_armatures)
    warnings.push_back(
        {name + ", " + held.joint,
         fmt::format("its torque shows no inertia ({:.2g} +- {:.1g} kg m^2): its armature is held "
                     "at {:.2g}",
                     held.inertia, held.inertia_se, held.armature),
         "friction that lags behind the speed, or a delay, looks like a negative inertia; how the "
         "joint accelerates is assumed, not measured",
         "state its armature (robot.armature); record faster reversals of this joint"});
  if (const std::vector<std::string>& mended = fit.rigid_body.mended_links; !mended.empty())
    warnings.push_back({name,
                        fmt::format("no body has the inertia of {} in the robot's file: the "
                                    "nearest that one can have was taken",
                                    enumeration(mended)),
                        "it is a guess where the data do not determine it",
                        "correct the <inertia> of these links in the URDF"});
  if (fit.remarks)
    for (const data::FittedRemark& remark : *fit.remarks)
      warnings.push_back({name, remark.found, remark.meaning, remark.remedy});
  if (!fit.usable && fit.faults.empty())
    warnings.push_back(
        {name, fmt::format("the fit ended as \"{}\": {}", name_of(fit.outcome), fit.message),
         "its parameters are meaningless",
         "read the message; record data that excite what it names"});
  else if (fit.outcome == data::Outcome::kIterationLimit)
    warnings.push_back({name, "the fit stopped at its limit of iterations",
                        "the parameters are the best so far and may still change",
                        "raise the number of iterations of this model in the scene"});
}

void warn_of_joints(const data::FitFile& fit, const std::string& name, Warnings& warnings) {
  std::vector<std::string> split;
  for (const data::FittedJoint& joint : fit.joints) {
    if (joint.start_rms.size() > 1) {
      const auto [least, most] = std::ranges::minmax(joint.start_rms);
      if (most > kStartsDisagree * least)
        split.push_back(fmt::format("{} ({:.3g} to {:.3g} N m)", joint.joint, least, most));
    }
  }
  if (std::optional<Warning> bounds = bounds_of(fit, name)) warnings.push_back(*std::move(bounds));
  if (!split.empty())
    warnings.push_back(
        {name, "searches from several starts ended at different errors: " + enumeration(split),
         "the objective has several minima; the best of them was kept",
         "raise `starts` of this model and see whether the best one changes"});
}

/// "0.08 +- 0.001 of the motor's torque of joint_2, ..": the joints that show it.
std::string growth_in_words(const data::FittedLoadGrowth& growth,
                            std::span<const std::string> joints) {
  std::vector<std::string> words;
  for (Eigen::Index j = 0; j < std::min(growth.coefficient.size(), std::ssize(joints)); ++j)
    if (growth.is_seen(growth.coefficient[j], growth.standard_error[j]))
      words.push_back(fmt::format("{:.2g} +- {:.1g} of the {}'s torque of {}",
                                  growth.coefficient[j], growth.standard_error[j],
                                  growth.is_of_motor() ? "motor" : "link",
                                  joints[static_cast<std::size_t>(j)]));
  return enumeration(words);
}

void warn_of_regression(const data::FitFile& fit, const std::string& name,
                        std::span<const std::string> joints, Warnings& warnings) {
  const data::FittedRigidBody& rigid = fit.rigid_body;
  if (rigid.condition > kPoorCondition)
    warnings.push_back({name, fmt::format("condition of the regression {:.3g}", rigid.condition),
                        "some base parameters are poorly determined; see their standard errors",
                        "design the excitation anew, move more, or record longer"});
  if (rigid.slower)
    warnings.push_back({name, *rigid.slower,
                        "the speed asked for would have left too few rows of these joints",
                        "lower `min_speed_rad_s`, or record faster motion"});
  if (std::optional<Warning> growth = growth_of(fit, name, joints))
    warnings.push_back(*std::move(growth));
  std::vector<std::string> few;
  for (std::size_t j = 0; j < joints.size(); ++j) {
    if (j >= rigid.rows.size() || j >= rigid.rows_total.size()) break;
    if (const double share = static_cast<double>(rigid.rows[j]) / rigid.rows_total[j];
        share < kFewRows)
      few.push_back(fmt::format("{:.0f} % of {}", 100 * share, joints[j]));
  }
  if (!few.empty())
    warnings.push_back({name, "few rows entered the regression: " + enumeration(few),
                        "these joints are slow or reverse often, where friction looks like inertia",
                        "excite them faster, or lower `min_speed_rad_s`"});
}

void warn_of_learning(const data::FitFile& fit, const std::string& name, Warnings& warnings) {
  if (fit.em)
    for (const std::string& text : fit.em->warnings)
      warnings.push_back(
          {name, text, "a warning of the E-step", "see the filter's health among the plots"});
  if ((fit.em && fit.em->chosen < 0) || (fit.multi_step && fit.multi_step->chosen == 0))
    warnings.push_back({name, "training did not improve on its start",
                        "the model is the conventional fit it began with",
                        "lower the rate, train longer, or accept the conventional fit"});
  for (const auto* training : {&fit.torque, &fit.multi_step})
    if (*training && (*training)->skipped > 0)
      warnings.push_back({name, fmt::format("{} training steps were skipped", (*training)->skipped),
                          "their gradient was not finite", "lower the rate"});
  if (const int returns = fit.multi_step ? fit.multi_step->returns : 0; returns > 0)
    warnings.push_back({name,
                        fmt::format("training diverged and returned to its best point {} time{}",
                                    returns, returns > 1 ? "s" : ""),
                        "after each return it continues with 0.3 of the step length",
                        "lower the rate if the held-out error stays high"});
}

}  // namespace

Warning warning_of(const Unexplained& torque) {
  return {torque.joint.empty() ? torque.recording : torque.recording + ", " + torque.joint,
          torque.in_words(),
          "the recording is not of the arm as it was trained: another load, a stop or a collision, "
          "closed brakes, a motion of another kind; it cannot rank models",
          "check that recording, and leave it or that time out; or train on such motion too"};
}

std::vector<Warning> warnings_of(const Evaluation& evaluation) {
  Warnings warnings;
  for (const Summary& summary : evaluation.summary)
    for (const std::string& doubt : summary.doubts)
      warnings.push_back({summary.label, doubt, "the model is not to be trusted",
                          "see the warnings of its fit, and docs/my_fit_is_bad.md"});
  for (const Summary& summary : evaluation.summary)
    if (summary.diverged > 0)
      warnings.push_back(
          {summary.label,
           fmt::format("{} of {} rollouts diverged", summary.diverged, summary.rollouts),
           "in open loop the model departs from the robot; its errors are clamped",
           "use it for one-step prediction at most, or fit it by open-loop windows"});
  for (const Unexplained& torque : evaluation.unexplained) warnings.push_back(warning_of(torque));
  for (std::size_t h = 0; h < evaluation.horizons_s.size(); ++h)
    if (!evaluation.meaningless[h].empty())
      warnings.push_back(
          {fmt::format("horizon {:.4g} s", evaluation.horizons_s[h]), evaluation.meaningless[h],
           "this column cannot rank models",
           "judge by another horizon; lower the sensors' noise or choose a shorter one"});
  return warnings;
}

std::optional<Warning> bounds_of(const data::FitFile& fit, const std::string& name) {
  std::vector<std::string> bounds;
  for (const data::FittedJoint& joint : fit.joints)
    if (!joint.at_bound.empty())
      bounds.push_back(fmt::format("{} of {}", fmt::join(joint.at_bound, ", "), joint.joint));
  if (bounds.empty()) return {};
  return Warning{
      name, "on a bound: " + enumeration(bounds),
      "the data push these parameters further than the table of laws allows, so the law does not "
      "need them or cannot describe this joint",
      "read them as \"at least\" or \"at most\"; try fewer elements or another law"};
}

std::optional<Warning> growth_of(const data::FitFile& fit, const std::string& name,
                                 std::span<const std::string> joints) {
  const std::optional<data::FittedLoadGrowth>& growth = fit.rigid_body.load_growth;
  if (!growth || growth->modelled) return {};
  const bool of_motor = growth->is_of_motor();
  return Warning{
      name, "friction grows with the load: " + growth_in_words(*growth, joints),
      of_motor ? "this law has no such friction, so that its bodies are too heavy by about as "
                 "much: where the motor drives, g of friction per torque looks like 1/(1 - g) "
                 "of load"
               : "this law has no such friction: its Coulomb friction is that of a mean load",
      of_motor ? "take lvm, load_dependent or modifiers = [\"load\"] for masses and inertias"
               : "take lvm or modifiers = [\"gear_load\"]"};
}

std::vector<Warning> warnings_of(const data::FitFile& fit, const std::string& name,
                                 std::span<const std::string> joints) {
  Warnings warnings;
  warn_of_trust(fit, name, warnings);
  warn_of_joints(fit, name, warnings);
  warn_of_regression(fit, name, joints, warnings);
  warn_of_learning(fit, name, warnings);
  return warnings;
}

Warning infeasible_excitation(const std::string& recording) {
  return {recording, "the excitation violates a limit", "the robot could not run it as it is",
          "raise `restarts`, or shrink `half_range` of [excitation]"};
}

}  // namespace fricid::evaluate
