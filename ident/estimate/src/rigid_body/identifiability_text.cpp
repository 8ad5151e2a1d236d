#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "fricid/estimate/rigid_body/identifiability.hpp"

namespace fricid::estimate {

namespace {

const ParameterVerdict* find(const Identifiability& report, const std::string& name) {
  for (const ParameterVerdict& v : report.parameters)
    if (v.name == name) return &v;
  return nullptr;
}

bool is_friction(const ParameterVerdict& v) {
  return v.name.ends_with(" friction") || v.name.ends_with(kFrictionPerTorque) ||
         v.name.ends_with(" constant torque");
}

std::vector<std::string> without_inertia(const Identifiability& report,
                                         const dynamics::RobotModel& robot) {
  std::vector<std::string> joints;
  for (const JointInertia& found : report.without_inertia)
    joints.push_back(robot.joints[static_cast<std::size_t>(found.joint)].name);
  return joints;
}

/// "4.02 +- 0.03": to the first digit of the error.
std::string rounded(double value, double error) {
  constexpr int kMostDecimals = 9;
  const double decimals = -std::floor(std::log10(error));
  if (!(decimals <= kMostDecimals)) return fmt::format("{:.6g} +- {:.1g}", value, error);
  return fmt::format("{:.{}f} +- {:.1g}", value, std::max(0, static_cast<int>(decimals)), error);
}

/// "4.02 +- 0.03", "4 +- 1 weak", "not identified".
std::string with_error(const ParameterVerdict* v) {
  if (!v || v->verdict == Verdict::kNot) return "not identified";
  return rounded(v->value, v->standard_error) + (v->verdict == Verdict::kWeak ? " weak" : "");
}

/// The shorter of the lists of laws that can be fitted and of those that cannot.
std::string laws_in_words(const std::vector<std::string>& supported,
                          const std::vector<std::string>& not_supported) {
  if (supported.empty()) return "none (--verbose says why)\n";
  if (not_supported.empty()) return "all\n";
  const std::string with = fmt::format("{}", fmt::join(supported, ", ")),
                    without = fmt::format("{}", fmt::join(not_supported, ", "));
  return fmt::format("{} (--verbose says why)\n",
                     with.size() < without.size() ? "only " + with : "all but " + without);
}

}  // namespace

data::CheckedIdentifiability checked(const Identifiability& report,
                                     const dynamics::RobotModel& robot) {
  data::CheckedIdentifiability file;
  file.message = report.message;
  file.without_inertia = without_inertia(report, robot);
  file.mended_links = robot.mended_links;
  file.doubts = report.doubts;
  for (std::size_t j = 0; j < report.couplings.size(); ++j)
    if (const Coupling& c = report.couplings[j]; matters(c, c.r2))
      file.couplings.push_back({robot.joints[j].name, name_of_other(c, robot),
                                declared_factor(c, static_cast<int>(j)), 100 * c.share});
  for (const ParameterVerdict& v : report.parameters)
    file.parameters.push_back({.name = v.name,
                               .verdict = std::string(name_of(v.verdict)),
                               .value = v.value,
                               .standard_error = v.standard_error,
                               .percent = 100 * v.standard_error / v.size,
                               .words = v.words});
  for (const Grouping& g : report.groupings) file.groupings.push_back({g.name, g.words});
  for (std::size_t j = 0; j < report.joints.size(); ++j) {
    const Coverage& c = report.joints[j];
    data::CheckedJoint& own = file.joints.emplace_back();
    own = {.joint = robot.joints[j].name,
           .fastest = c.fastest,
           .slow_s = c.slow_s,
           .reversals = c.reversals,
           .presliding = c.presliding,
           .samples_per_climb = c.samples_per_climb,
           .load = {c.load_low, c.load_high},
           .temperature = {},
           .resolution = c.resolution};
    if (c.temperature_low <= c.temperature_high)
      own.temperature = {c.temperature_low, c.temperature_high};
  }
  for (const FamilyVerdict& f : report.families)
    file.families.push_back({f.family, f.supported, f.words});
  return file;
}

std::string to_text(const Identifiability& report, const dynamics::RobotModel& robot) {
  std::string text;
  if (!report.message.empty()) text += fmt::format("parameters: none: {}\n", report.message);
  for (const ParameterVerdict& v : report.parameters) {
    const double percent = 100 * v.standard_error / v.size;
    text += fmt::format("parameter: {}: {} ({}{:.2g} %){}{}\n", v.name, name_of(v.verdict),
                        percent > 999 ? "> " : "", std::min(percent, 999.0),
                        v.words.empty() ? "" : ": ", v.words);
  }
  for (const std::string& doubt : report.doubts) text += fmt::format("doubt: {}\n", doubt);
  for (const JointInertia& found : report.without_inertia)
    text += fmt::format(
        "inertia: {}: {:.2g} +- {:.1g} {} by its torque: a fit holds its armature\n",
        robot.joints[static_cast<std::size_t>(found.joint)].name, found.value, found.error,
        slides(robot.joints[static_cast<std::size_t>(found.joint)]) ? "kg" : "kg m^2");
  for (std::size_t j = 0; j < report.joints.size(); ++j) {
    const Coverage& c = report.joints[j];
    text += fmt::format(
        "friction: {}: up to {:.3g} {}, {:.3g} s below the Stribeck speed, {} reversals, {} "
        "presliding excursions, {:.0f} samples per presliding, {:.4g} to {:.4g} {}{}\n",
        robot.joints[j].name, c.fastest, slides(robot.joints[j]) ? "m/s" : "rad/s", c.slow_s,
        c.reversals, c.presliding, c.samples_per_climb, c.load_low, c.load_high,
        slides(robot.joints[j]) ? "N" : "N m",
        c.temperature_low <= c.temperature_high
            ? fmt::format(", {:.4g} to {:.4g} K", c.temperature_low, c.temperature_high)
            : ", no temperature");
  }
  for (const FamilyVerdict& f : report.families)
    text +=
        fmt::format("family: {}: {}{}{}\n", f.family, f.supported ? "supported" : "not supported",
                    f.words.empty() ? "" : ": ", f.words);
  return text;
}

std::string to_summary(const Identifiability& report, const dynamics::RobotModel& robot,
                       bool damaged) {
  if (!report.message.empty()) return fmt::format("parameters: none: {}\n", report.message);
  std::string text;
  for (const std::string& doubt : report.doubts)
    text += fmt::format("not to be trusted: {}\n", doubt);
  int all = 0, weak = 0, lost = 0;
  for (const ParameterVerdict& v : report.parameters) {
    if (is_friction(v)) continue;
    ++all;
    weak += v.verdict == Verdict::kWeak;
    lost += v.verdict == Verdict::kNot;
  }

  std::string table = fmt::format("\n{:<20} {:>8} {:>9} {:>20} {:>20}\n", "joint", "rad/s",
                                  "reversals", "Coulomb N m", "viscous N m s/rad");
  std::vector<std::string> lacking;  // joints whose friction is not identified
  for (std::size_t j = 0; j < report.joints.size(); ++j) {
    const std::string& joint = robot.joints[j].name;
    const ParameterVerdict *coulomb = find(report, joint + " Coulomb friction"),
                           *viscous = find(report, joint + " viscous friction");
    table += fmt::format("{:<20} {:>8.3g} {:>9} {:>20} {:>20}{}\n", joint, report.joints[j].fastest,
                         report.joints[j].reversals, with_error(coulomb), with_error(viscous),
                         slides(robot.joints[j]) ? "  (m/s, N, N s/m)" : "");
    const auto told = [](const ParameterVerdict* v) {
      return v && v->verdict == Verdict::kIdentified;
    };
    if (!told(coulomb) || !told(viscous)) lacking.push_back(joint);
  }

  std::vector<std::string> supported, not_supported;
  for (const FamilyVerdict& f : report.families)
    (f.supported ? supported : not_supported).push_back(f.family);

  text += fmt::format("rigid body: {} of {} base parameters identified, {} weakly, {} not{}",
                      all - weak - lost, all, weak, lost,
                      lost > 0 ? "; these need nominal values" : "");
  if (!report.without_inertia.empty())
    text += fmt::format("; no inertia in the torque of {}: a fit holds the armature",
                        fmt::join(without_inertia(report, robot), ", "));
  if (!robot.mended_links.empty())
    text += fmt::format("; inertia mended of {}", fmt::join(robot.mended_links, ", "));
  text += '\n';
  text += lacking.empty()
              ? "friction: Coulomb and viscous identified on every joint"
              : fmt::format("friction: poorly identified on {}", fmt::join(lacking, ", "));
  for (std::size_t j = 0; j < report.couplings.size(); ++j)
    if (const Coupling& c = report.couplings[j]; matters(c, c.r2)) {
      const std::string declaration = declaration_of(c, static_cast<int>(j), robot);
      text += fmt::format(
          "; that of {} depends on the speed of {} too: {}", robot.joints[j].name,
          name_of_other(c, robot),
          declaration.empty()
              ? "it is at motors and joints, of which a model has one"
              : fmt::format("{}, if {} both", declaration,
                            c.factor_of_second == 0 ? "one motor turns" : "two motors turn"));
    }
  std::vector<std::string> growth;
  for (const ParameterVerdict& v : report.parameters)
    if (v.name.ends_with(kFrictionPerTorque))
      growth.push_back(fmt::format("{} {}", with_error(&v),
                                   v.name.substr(0, v.name.size() - kFrictionPerTorque.size())));
  if (!growth.empty())
    text += report.growth_of == GearSide::kMotor
                ? fmt::format(
                      "; it grows with the torque of the motor ({}): take a law with load, "
                      "others find bodies that are too heavy",
                      fmt::join(growth, ", "))
                : fmt::format(
                      "; it grows with the torque that reaches the link ({}): take lvm or "
                      "modifiers = [\"gear_load\"]",
                      fmt::join(growth, ", "));
  text += '\n';
  text += "laws: " + laws_in_words(supported, not_supported);
  text += damaged ? "next: mend what is named above, and check again\n"
          : weak + lost == 0 && lacking.empty()
              ? "next: nothing is missing for rigid body, Coulomb and viscous friction\n"
              : fmt::format("next: record the trajectory of --design next.toml{}\n",
                            lacking.empty() ? ""
                                            : fmt::format(", faster and longer on {}",
                                                          fmt::join(lacking, ", ")));
  return text + table;
}

}  // namespace fricid::estimate
