#include <cmath>
#include <nlohmann/json.hpp>

#include <fmt/format.h>

#include "fricid/estimate/rigid_body/identifiability.hpp"

namespace fricid::estimate {

using Json = nlohmann::ordered_json;

std::string to_json(const Identifiability& report, const dynamics::RobotModel& robot) {
  Json parameters = Json::array(), groupings = Json::array(), joints = Json::array(),
       families = Json::array();
  for (const ParameterVerdict& v : report.parameters)
    parameters.push_back({{"name", v.name},
                          {"verdict", to_string(v.verdict)},
                          {"value", v.value},
                          {"standard_error", v.standard_error},
                          {"percent", 100 * v.standard_error / v.size},
                          {"words", v.words}});
  for (const Grouping& g : report.groupings)
    groupings.push_back({{"name", g.name}, {"words", g.words}});
  for (std::size_t j = 0; j < report.joints.size(); ++j) {
    const Coverage& c = report.joints[j];
    joints.push_back({{"joint", robot.joints[j].name},
                      {"fastest_rad_s", c.fastest},
                      {"slow_s", c.slow_s},
                      {"reversals", c.reversals},
                      {"presliding_excursions", c.presliding},
                      {"samples_per_climb", c.samples_per_climb},
                      {"load_Nm", {c.load_low, c.load_high}},
                      {"temperature_K", {c.temperature_low, c.temperature_high}},
                      {"resolution_rad", c.resolution}});
  }
  for (const FamilyVerdict& f : report.families)
    families.push_back({{"family", f.family}, {"supported", f.supported}, {"words", f.words}});
  const Json out{{"format", "fricid.check/1"},  {"message", report.message},
                 {"parameters", parameters},    {"not_alone", groupings},
                 {"friction_coverage", joints}, {"families", families}};
  return out.dump(2) + "\n";
}

std::string to_text(const Identifiability& report, const dynamics::RobotModel& robot) {
  std::string text;
  if (!report.message.empty()) text += fmt::format("parameters: none: {}\n", report.message);
  for (const ParameterVerdict& v : report.parameters) {
    const double percent = 100 * v.standard_error / v.size;
    text += fmt::format("parameter: {}: {} ({}{:.2g} %){}{}\n", v.name, to_string(v.verdict),
                        percent > 999 ? "> " : "", std::min(percent, 999.0),
                        v.words.empty() ? "" : ": ", v.words);
  }
  for (std::size_t j = 0; j < report.joints.size(); ++j) {
    const Coverage& c = report.joints[j];
    text += fmt::format(
        "friction: {}: up to {:.3g} rad/s, {:.3g} s below the Stribeck speed, {} reversals, {} "
        "excursions before sliding, {:.0f} samples per climb, {:.4g} to {:.4g} N m, {:.4g} to "
        "{:.4g} K\n",
        robot.joints[j].name, c.fastest, c.slow_s, c.reversals, c.presliding, c.samples_per_climb,
        c.load_low, c.load_high, c.temperature_low, c.temperature_high);
  }
  for (const FamilyVerdict& f : report.families)
    text += fmt::format("family: {}: {}{}{}\n", f.family, f.supported ? "supported" : "not",
                        f.words.empty() ? "" : ": ", f.words);
  return text;
}

}  // namespace fricid::estimate
