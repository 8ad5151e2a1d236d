#include "torque/fit_joint.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>

#include <fmt/format.h>

#include "fricid/estimate/torque/joint_fit.hpp"
#include "support.hpp"
#include "torque/trials.hpp"

namespace fricid::estimate {

FitReport fit_joint(const Prepared& prepared, const ModelOptions& config, int seed, int jobs) {
  const auto begin = std::chrono::steady_clock::now();
  FitReport report;
  report.method = Method::kJoint;
  report.fitted_to = prepared.fitted_to;
  report.rigid_body = prepared.rigid_body;
  report.model.name = config.name;
  report.model.label = config.label.empty() ? config.name : config.label;
  report.model.seed = seed;
  report.residual_rms.resize(static_cast<std::size_t>(prepared.robot.n()));
  report.r2.resize(report.residual_rms.size());

  MultiStepOptions windows = config.train;
  windows.seed = static_cast<std::uint64_t>(seed);
  const JointFits fits(prepared, windows, jobs);
  Trials trials(prepared, fits, config, seed);
  if (is_sum(config))
    trials.add_sum(report.parts);
  else
    trials.add_law(joint_spec_of(config));
  if (fits.has_room_for_windows()) trials.add_windows();
  const Trial& best = trials.take();
  report.candidates = trials.candidates();
  report.model.arm = trials.on_all_rows(best);
  for (PartEvidence& part : report.parts)
    if (part.part == friction::SumPart::kNetwork)
      part.on = friction::find_parameter(report.model.arm.friction.model, part.joint,
                                         friction::Role::kNetworkTorque) >= 0;
  report.model.budget = fmt::format("{} candidates", report.candidates.size());
  report.model.free_parameters =
      best.candidate.parameters + static_cast<int>(prepared.rigid_body.base.size());
  const bool finite =
      std::isfinite(best.candidate.held_out) && report.model.arm.robot.pi.allFinite();
  report.outcome = finite ? Outcome::kConverged : Outcome::kFailed;
  report.message =
      fmt::format("{} of {} candidates, held-out error {:.2e} rad2", best.candidate.name,
                  report.candidates.size(), best.candidate.held_out);
  if (!finite) return report;
  const std::vector<Arm> folds = fits.cross_fit(report.model.arm);
  for (std::size_t f = 0; f < folds.size(); ++f)
    for (std::size_t i = 0; i < prepared.recordings.size(); ++i)
      if (const auto stretch = fits.folds()[f].left_out_of(static_cast<int>(i)))
        report.without.push_back({prepared.recordings[i].log.name, *stretch, folds[f]});
  report.model.noise = assumed_noise(report.model.arm, prepared.recordings);
  score_torque(prepared, prepared.options.cutoff_hz, jobs, report);
  report.faults = faults_of(prepared, report);
  report.seconds = seconds_since(begin);
  return report;
}

}  // namespace fricid::estimate
