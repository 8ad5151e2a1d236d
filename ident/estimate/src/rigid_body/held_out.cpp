#include "fricid/estimate/rigid_body/held_out.hpp"

#include "fricid/base/parallel.hpp"
#include "fricid/estimate/prepared.hpp"
#include "rigid_body/contradictions.hpp"
#include "rigid_body/regression_start.hpp"

namespace fricid::estimate {

std::vector<std::vector<Fault>> find_differences_from_training(
    const dynamics::RobotModel& robot, std::span<const data::Dataset> training,
    std::span<const data::Dataset> held_out, const RigidBodyOptions& options, int jobs) {
  std::vector<std::vector<Fault>> found(held_out.size());
  if (training.empty() || held_out.empty()) return found;
  const std::vector<signals::Recording> learnt =
                                            recordings_of(robot, training, options.cutoff_hz, jobs),
                                        others =
                                            recordings_of(robot, held_out, options.cutoff_hz, jobs);
  const RegressionStart start = start_of_regression(robot, options);
  const RigidBodyFit fit = rigid_body_least_squares(start.robot, learnt, start.options);
  if (fit.outcome != Outcome::kConverged || !fit.prior.empty()) return found;
  if (!find_contradictions(start.robot, learnt, start.options, fit).empty()) return found;
  parallel_for(static_cast<int>(held_out.size()), jobs, [&](int i) {
    const auto at = static_cast<std::size_t>(i);
    std::vector<signals::Recording> together = learnt;
    together.push_back(others[at]);
    found[at] = find_differences(start.robot, together, start.options);
  });
  return found;
}

}  // namespace fricid::estimate
