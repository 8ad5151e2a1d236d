#include "fricid/estimate/fit_report.hpp"

#include <cmath>

#include <fmt/format.h>

#include "fricid/data/training_part.hpp"
#include "rigid_body/frictionless.hpp"
#include "support.hpp"
#include "torque/fit_joint.hpp"

namespace fricid::estimate {

FitReport empty_report(const Prepared& prepared, const ModelOptions& options, int seed) {
  const auto n = static_cast<std::size_t>(prepared.robot.n());
  FitReport report;
  report.fitted_to = prepared.fitted_to;
  // beyond the gear there may be none
  report.frictionless = !is_beyond_gear(prepared.recordings) &&
                        is_frictionless(prepared.recordings, prepared.rigid_body);
  report.model.name = options.name;
  report.model.label = options.label.empty() ? options.name : options.label;
  report.model.seed = seed;
  report.model.arm.robot = prepared.robot;
  for (std::vector<double>* of_joints :
       {&report.residual_rms, &report.r2, &report.sliding_r2, &report.resting_rms})
    of_joints->resize(n);
  return report;
}

std::vector<std::string> FitReport::doubts() const {
  std::vector<std::string> lines;
  for (const Fault& fault : faults) lines.push_back(in_words(fault));
  if (lines.empty() && !usable()) lines.push_back(message);
  return lines;
}

std::string FitReport::brief() const {
  double sum = 0, finite = 0;
  for (const double value : r2)
    if (std::isfinite(value)) sum += value, finite += 1;
  const std::string explained =
      finite > 0 ? fmt::format("R2 {:.4f} on training torque", sum / finite) : "no finite torque";
  return fmt::format("{} seed {}: {}{}, {}, {} parameters, {:.1f} s{}", model.name, model.seed,
                     usable() ? "" : "NOT TO BE TRUSTED: ", name_of(outcome), explained,
                     model.free_parameters, seconds,
                     fitted_to ? ", fitted to " + data::in_words(*fitted_to) : "");
}

}  // namespace fricid::estimate
