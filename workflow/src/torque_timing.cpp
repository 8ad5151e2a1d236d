#include "fricid/workflow/torque_timing.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <utility>

#include "fricid/base/error.hpp"
#include "fricid/data/training_part.hpp"
#include "fricid/estimate/prepared.hpp"
#include "fricid/estimate/rigid_body/torque_timing.hpp"

namespace fricid::workflow {
namespace {

constexpr double kMatters = 1e-3;  // [s] of what is not known, to be said
constexpr int kSamples = 80'000;   // tell the delay to some hundredths of one

/// Nothing where a log is no recording; who reads it on says why.
std::optional<estimate::TorqueTiming> timing_of(std::span<const data::Dataset> sets,
                                                const dynamics::RobotModel& robot) {
  const estimate::RigidBodyOptions options;
  std::vector<signals::Recording> recordings;
  try {
    recordings = estimate::recordings_of(robot, data::training_part(sets, kSamples).recordings,
                                         options.cutoff_hz, 1);
  } catch (const UserError&) {
    return {};
  }
  return estimate::torque_timing(robot, recordings, options);
}

}  // namespace

void settle_torque_timing(std::span<data::Dataset> logs, const dynamics::RobotModel& robot,
                          const data::TorqueColumns& torque,
                          const std::function<void(const std::string&)>& say) {
  if (torque.timing != "auto" || torque.delay_s != 0) return;
  const std::optional<estimate::TorqueTiming> timing = timing_of(logs, robot);
  if (!timing) return;
  if (!timing->is_at_samples()) {
    double slowest = 0;
    for (data::Dataset& log : logs) {
      log.torque_delay_sd =
          data::delay_sd_if_measured(timing->likelihood_at_samples(log.dt()), log.dt());
      slowest = std::max(slowest, log.torque_delay_sd);
    }
    if (slowest > kMatters)
      say("the logs do not tell whether the torque is held from its samples or measured at them, "
          "half a sample later: standard errors contain it, and [torque] timing = \"held\" or "
          "\"measured\" in the contract ends it");
    return;
  }
  for (data::Dataset& log : logs) log = data::held_between_samples(std::move(log));
  say(
      fmt::format("the torque is measured at its samples ({:.2f} +- {:.2g} samples later than one "
                  "held from them), and is taken as its mean between them; "
                  "[torque] timing = \"held\" leaves it as it is",
                  timing->delay, timing->standard_error));
}

}  // namespace fricid::workflow
