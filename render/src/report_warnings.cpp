#include <algorithm>

#include <fmt/format.h>

#include "html.hpp"
#include "report_parts.hpp"

namespace fricid::render {
namespace {

constexpr double kPoorCondition = 100;    // of the regression's columns, scaled to unit length
constexpr double kStartsDisagree = 1.05;  // worst start over best, in RMS
constexpr double kFewRows = 0.5;          // share of the recording

std::string name_of(const FittedModel& fitted) {
  return fitted.model.seeds.size() > 1
             ? fmt::format("{}, seed {}", fitted.model.label, fitted.id.seed)
             : fitted.model.label;
}

void warn_of_fit(const Run& run, const FittedModel& fitted, std::vector<Warning>& warnings) {
  const data::FitFile& fit = *fitted.fit;
  const std::string name = name_of(fitted);
  for (const data::FittedFault& fault : fit.faults)
    warnings.push_back({name + (fault.joint.empty() ? "" : ", ") + fault.joint, fault.found,
                        "the fit is not to be trusted", fault.remedy});
  if (const std::string& prior = fit.rigid_body.prior; !prior.empty() && prior != "asked for")
    warnings.push_back({name, "the robot's nominal values entered as a prior: " + prior,
                        "the data alone do not determine the rigid body",
                        "record more and faster motion, or state good nominal values"});
  if (!fit.usable && fit.faults.empty())
    warnings.push_back(
        {name, fmt::format("the fit ended as \"{}\": {}", to_string(fit.outcome), fit.message),
         "its parameters mean nothing", "read the message; record data that excite what it names"});
  else if (fit.outcome == data::Outcome::kIterationLimit)
    warnings.push_back({name, "the fit stopped at its limit of iterations",
                        "the parameters are the best so far and may still move",
                        "raise the number of iterations of this model in the scene"});

  std::vector<std::string> bounds, split;
  for (const data::FittedJoint& joint : fit.joints) {
    if (!joint.at_bound.empty())
      bounds.push_back(fmt::format("{} of {}", fmt::join(joint.at_bound, ", "), joint.joint));
    if (joint.start_rms.size() > 1) {
      const auto [least, most] = std::ranges::minmax(joint.start_rms);
      if (most > kStartsDisagree * least)
        split.push_back(fmt::format("{} ({:.3g} to {:.3g} N m)", joint.joint, least, most));
    }
  }
  if (!bounds.empty())
    warnings.push_back(
        {name, "on a bound: " + html::enumeration(bounds),
         "the data push these parameters further than the table of laws allows, so the law has no "
         "use for them or cannot describe this joint",
         "read them as \"at least\" or \"at most\"; try fewer elements or another law"});
  if (!split.empty())
    warnings.push_back({name,
                        "searches from several starts ended apart: " + html::enumeration(split),
                        "the objective has several minima; the best of them was kept",
                        "raise `starts` of this model and see whether the best one stays"});
  const data::FittedRigidBody& rigid = fit.rigid_body;
  if (rigid.condition > kPoorCondition)
    warnings.push_back({name, fmt::format("condition of the regression {:.3g}", rigid.condition),
                        "some base parameters are poorly determined; see their standard errors",
                        "design the excitation anew, move more, or record longer"});
  std::vector<std::string> few;
  for (int j = 0; j < run.n(); ++j) {
    const auto at = static_cast<std::size_t>(j);
    if (at >= rigid.rows.size() || at >= rigid.rows_total.size()) break;
    if (const double share = static_cast<double>(rigid.rows[at]) / rigid.rows_total[at];
        share < kFewRows)
      few.push_back(fmt::format("{:.0f} % of {}", 100 * share, run.joint(j)));
  }
  if (!few.empty())
    warnings.push_back({name, "few rows entered the regression: " + html::enumeration(few),
                        "these joints are slow or reverse often, where friction looks like inertia",
                        "excite them faster, or lower `min_speed_rad_s`"});
}

void warn_of_learning(const FittedModel& fitted, std::vector<Warning>& warnings) {
  const std::string name = name_of(fitted);
  const data::FitFile& fit = *fitted.fit;
  if (fit.em)
    for (const std::string& text : fit.em->warnings)
      warnings.push_back({name, text, "what the E-step said while it ran",
                          "see the filter's health among the plots"});
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
                        fmt::format("training lost its way and went back to its best {} time{}",
                                    returns, returns > 1 ? "s" : ""),
                        "after each return it goes on with 0.3 of the step length",
                        "lower the rate if the held-out error stays high"});
}

void warn_of_evaluation(const evaluate::Evaluation& evaluation, std::vector<Warning>& warnings) {
  for (const evaluate::Summary& summary : evaluation.summary)
    for (const std::string& doubt : summary.doubts)
      warnings.push_back({summary.label, doubt, "the model is not to be trusted",
                          "see what its fit says in this list, and docs/my_fit_is_bad.md"});
  for (const evaluate::Summary& summary : evaluation.summary)
    if (summary.diverged > 0)
      warnings.push_back(
          {summary.label,
           fmt::format("{} of {} rollouts diverged", summary.diverged, summary.rollouts),
           "in free run the model leaves the robot; its figures are clamped",
           "use it for one-step prediction at most, or fit it by multi-step windows"});
  for (std::size_t h = 0; h < evaluation.horizons_s.size(); ++h)
    if (!evaluation.meaningless[h].empty())
      warnings.push_back(
          {fmt::format("horizon {:.4g} s", evaluation.horizons_s[h]), evaluation.meaningless[h],
           "this column cannot rank models",
           "judge by another horizon; lower the sensors' noise or choose shorter ones"});
}

void warn_of_excitation(const Record& record, std::vector<Warning>& warnings) {
  for (const sim::TrajectoryReport& trajectory : record.trajectories)
    if (!trajectory.feasible)
      warnings.push_back({trajectory.name, "the excitation breaks a limit",
                          "the robot could not run it as it is",
                          "raise `restarts`, or shrink `half_range` of [excitation]"});
}

}  // namespace

std::vector<Warning> warnings_of(const Record& record) {
  std::vector<Warning> warnings;
  warn_of_evaluation(record.run.evaluation, warnings);
  for (const FittedModel& fitted : record.fits) {
    if (!fitted.fit) continue;
    warn_of_fit(record.run, fitted, warnings);
    warn_of_learning(fitted, warnings);
  }
  warn_of_excitation(record, warnings);
  return warnings;
}

Html warning_section(const std::vector<Warning>& warnings) {
  Html text = Html::of("<h2 id=\"warnings\">Warnings</h2>\n");
  if (warnings.empty()) return text + Html::of("<p>None.</p>\n");
  for (const Warning& warning : warnings)
    text += Html::of(
        "<div class=\"warning\"><p><b>{}</b>: {}.</p><p class=\"note\">Meaning: {}. Remedy: "
        "{}.</p></div>\n",
        html::escaped(warning.subject), html::escaped(warning.found),
        html::escaped(warning.meaning), html::escaped(warning.remedy));
  return text;
}

}  // namespace fricid::render
