#include "fricid/estimate/rigid_body/held_out.hpp"

#include "fricid/base/parallel.hpp"
#include "fricid/data/training_part.hpp"
#include "fricid/system/transmission.hpp"
#include "rigid_body/contradictions.hpp"
#include "rigid_body/regression_start.hpp"

namespace fricid::estimate {

std::vector<std::vector<Fault>> find_differences_from_training(
    const dynamics::RobotModel& robot, std::span<const data::Dataset> training,
    std::span<const data::Dataset> held_out, const RigidBodyOptions& options, int jobs) {
  std::vector<std::vector<Fault>> found(held_out.size());
  if (training.empty() || held_out.empty()) return found;
  const Transmission motors(robot);
  const auto recorded = [&](const data::Dataset& d) {
    return signals::make_recording(motors.to_motors(d), options.cutoff_hz);
  };
  const data::TrainingPart part = data::training_part(training);
  std::vector<signals::Recording> recordings(part.recordings.size());
  parallel_for(static_cast<int>(recordings.size()), jobs, [&](int i) {
    recordings[static_cast<std::size_t>(i)] =
        recorded(part.recordings[static_cast<std::size_t>(i)]);
  });
  const RegressionStart start = start_of_regression(robot, options);
  const RigidBodyFit fit = rigid_body_least_squares(start.robot, recordings, start.options);
  if (fit.outcome != Outcome::kConverged || !fit.prior.empty()) return found;
  if (!find_contradictions(start.robot, recordings, start.options, fit).empty()) return found;
  parallel_for(static_cast<int>(held_out.size()), jobs, [&](int i) {
    std::vector<signals::Recording> together = recordings;
    together.push_back(recorded(held_out[static_cast<std::size_t>(i)]));
    found[static_cast<std::size_t>(i)] = find_differences(start.robot, together, start.options);
  });
  return found;
}

}  // namespace fricid::estimate
