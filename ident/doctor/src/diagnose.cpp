#include <algorithm>

#include "checks.hpp"
#include "fricid/doctor/doctor.hpp"

namespace fricid::doctor {

std::vector<Finding> diagnose(const data::Dataset& d, const dynamics::RobotModel* robot) {
  Findings findings;
  check_clock(d, findings);
  check_signals(d, findings);
  find_segments(d, findings);

  // The rest needs even times: what was found so far is mended for it, single wrong samples too.
  std::vector<std::string> mended;
  for (const char* name :
       {"jitter", "clock_drift", "duplicate", "gap", "spike", "repeated", "jump"})
    if (std::any_of(findings.begin(), findings.end(),
                    [&](const Finding& f) { return f.name == name; }))
      mended.emplace_back(name);
  const data::Dataset even = mended.empty() ? d : repair(d, findings, mended);
  const std::size_t before = findings.size();
  check_dynamics(even, robot, findings);
  std::vector<std::string> misnamed;
  for (std::size_t i = before; i < findings.size(); ++i)
    if (kind_of(findings[i].name).fixable && findings[i].name != "delay" &&
        std::find(misnamed.begin(), misnamed.end(), findings[i].name) == misnamed.end())
      misnamed.push_back(findings[i].name);
  check_velocity(misnamed.empty() ? even : repair(even, findings, misnamed), findings);
  return findings;
}

}  // namespace fricid::doctor
