#include <algorithm>
#include <cmath>

#include "html.hpp"
#include "json_files.hpp"
#include "report_parts.hpp"

namespace fricid::render {
namespace {

using nlohmann::json;

constexpr double kPoorCondition = 100;    // of the regression's columns, scaled to unit length
constexpr double kStartsDisagree = 1.05;  // worst start over best, in RMS
constexpr double kFewRows = 0.5;          // share of the recording

std::string name_of(const FittedModel& fitted) {
  return fitted.model.seeds.size() > 1 ? fmt::format("{}, seed {}", fitted.model.label, fitted.seed)
                                       : fitted.model.label;
}

std::vector<std::string> texts_in(const json& object, const char* key) {
  std::vector<std::string> texts;
  if (object.is_object() && object.contains(key))
    for (const json& text : object.at(key))
      if (text.is_string()) texts.push_back(text.get<std::string>());
  return texts;
}

void warn_of_fit(const FittedModel& fitted, std::vector<Warning>& warnings) {
  const json& fit = fitted.fit;
  const std::string name = name_of(fitted);
  const std::string outcome = fit.value("outcome", "converged");
  if (!fit.value("usable", true))
    warnings.push_back({name, "the fit ended as \"" + outcome + "\": " + fit.value("message", ""),
                        "its parameters mean nothing",
                        "read the message; record data that excite what it names"});
  else if (outcome == "iteration limit")
    warnings.push_back({name, "the fit stopped at its limit of iterations",
                        "the parameters are the best so far and may still move",
                        "raise the number of iterations of this model in the scene"});

  std::vector<std::string> bounds, split;
  for (const json& joint : fit.value("joints", json::array())) {
    const std::vector<std::string> symbols = texts_in(joint, "at_bound");
    if (!symbols.empty())
      bounds.push_back(fmt::format("{} of {}", fmt::join(symbols, ", "), joint.value("joint", "")));
    const std::vector<double> starts = numbers_in(joint, "start_rms_Nm");
    if (starts.size() > 1) {
      const auto [least, most] = std::minmax_element(starts.begin(), starts.end());
      if (*most > kStartsDisagree * *least)
        split.push_back(
            fmt::format("{} ({:.3g} to {:.3g} N m)", joint.value("joint", ""), *least, *most));
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
  const double condition = number_in(fit.value("rigid_body", json::object()), "condition");
  if (condition > kPoorCondition)
    warnings.push_back({name, fmt::format("condition of the regression {:.3g}", condition),
                        "some base parameters are poorly determined; see their standard errors",
                        "design the excitation anew, move more, or record longer"});
  const json rigid = fit.value("rigid_body", json::object());
  const std::vector<double> used = numbers_in(rigid, "rows_used"),
                            total = numbers_in(rigid, "rows_total");
  std::vector<std::string> few;
  for (std::size_t j = 0; j < used.size() && j < total.size(); ++j)
    if (used[j] < kFewRows * total[j])
      few.push_back(fmt::format("{:.0f} % of {}", 100 * used[j] / total[j],
                                rigid.at("joints").at(j).get<std::string>()));
  if (!few.empty())
    warnings.push_back({name, "few rows entered the regression: " + html::enumeration(few),
                        "these joints are slow or reverse often, where friction looks like inertia",
                        "excite them faster, or lower `min_speed_rad_s`"});
}

void warn_of_learning(const FittedModel& fitted, std::vector<Warning>& warnings) {
  const std::string name = name_of(fitted);
  const json em = fitted.fit.value("em", json::object());
  for (const std::string& text : texts_in(em, "warnings"))
    warnings.push_back({name, text, "what the E-step said while it ran",
                        "see the filter's health among the plots"});
  for (const char* method : {"em", "multi_step"}) {
    const json report = fitted.fit.value(method, json::object());
    if (report.is_object() && report.contains("chosen") && report.at("chosen").is_number() &&
        report.at("chosen").get<int>() <= 0)
      warnings.push_back({name, "training did not improve on its start",
                          "the model is the conventional fit it began with",
                          "lower the rate, train longer, or accept the conventional fit"});
  }
  for (const char* method : {"torque", "multi_step"})
    if (const int skipped = fitted.fit.value(method, json::object()).value("skipped", 0);
        skipped > 0)
      warnings.push_back({name, fmt::format("{} training steps were skipped", skipped),
                          "their gradient was not finite", "lower the rate"});
  if (const int returns = fitted.fit.value("multi_step", json::object()).value("returns", 0);
      returns > 0)
    warnings.push_back({name,
                        fmt::format("training lost its way and went back to its best {} time{}",
                                    returns, returns > 1 ? "s" : ""),
                        "after each return it goes on with 0.3 of the step length",
                        "lower the rate if the held-out error stays high"});
}

void warn_of_evaluation(const Record& record, std::vector<Warning>& warnings) {
  const json& evaluation = record.run.evaluation;
  for (const json& summary : evaluation.at("summary"))
    if (const int diverged = summary.value("diverged", 0); diverged > 0)
      warnings.push_back(
          {summary.value("label", ""),
           fmt::format("{} of {} rollouts diverged", diverged, summary.value("rollouts", 0)),
           "in free run the model leaves the robot; its figures are clamped",
           "use it for one-step prediction at most, or fit it by multi-step windows"});
  const std::vector<double> horizons = numbers_in(evaluation, "horizons_s");
  const json meaningless = evaluation.value("meaningless", json::array());
  for (std::size_t h = 0; h < meaningless.size() && h < horizons.size(); ++h)
    if (meaningless[h].is_string())
      warnings.push_back(
          {fmt::format("horizon {:.4g} s", horizons[h]), meaningless[h].get<std::string>(),
           "this column cannot rank models",
           "judge by another horizon; lower the sensors' noise or choose shorter ones"});
}

void warn_of_excitation(const Record& record, std::vector<Warning>& warnings) {
  if (!record.excitation.is_array()) return;
  for (const json& report : record.excitation)
    if (!report.value("feasible", true))
      warnings.push_back({report.value("name", ""), "the excitation breaks a limit",
                          "the robot could not run it as it is",
                          "raise `restarts`, or shrink `half_range` of [excitation]"});
}

}  // namespace

std::vector<Warning> warnings_of(const Record& record) {
  std::vector<Warning> warnings;
  warn_of_evaluation(record, warnings);
  for (const FittedModel& fitted : record.fits) {
    warn_of_fit(fitted, warnings);
    warn_of_learning(fitted, warnings);
  }
  warn_of_excitation(record, warnings);
  return warnings;
}

std::string warning_section(const std::vector<Warning>& warnings) {
  std::string text = "<h2 id=\"warnings\">Warnings</h2>\n";
  if (warnings.empty()) return text + "<p>None.</p>\n";
  for (const Warning& warning : warnings)
    text += fmt::format(
        "<div class=\"warning\"><p><b>{}</b>: {}.</p><p class=\"note\">Meaning: {}. Remedy: "
        "{}.</p></div>\n",
        html::escaped(warning.subject), html::escaped(warning.found),
        html::escaped(warning.meaning), html::escaped(warning.remedy));
  return text;
}

}  // namespace fricid::render
