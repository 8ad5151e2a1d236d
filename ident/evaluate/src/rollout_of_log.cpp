#include "fricid/evaluate/rollout_of_log.hpp"

#include <utility>

#include "fricid/base/error.hpp"
#include "fricid/signals/recording.hpp"
#include "planned_rollouts.hpp"

namespace fricid::evaluate {

Rollout roll_out_log(const data::ModelFile& model, const data::Dataset& log, double cutoff_hz,
                     int begin, int steps, const RolloutOptions& options) {
  if (begin < 0 || steps < 1 || steps > log.length() - 1 - begin)
    throw UserError("{}: {} steps from sample {}; allowed: 1 or more, up to sample {}", log.name,
                    steps, begin, log.length() - 1);
  if (log.n() != model.arm.robot.n())
    throw UserError("{}: {} joints, the model has {}", log.name, log.n(), model.arm.robot.n());
  signals::Motion motion = signals::make_recording(log, cutoff_hz).narrow;
  const Trajectory trajectory{
      .data = log, .q = std::move(motion.q), .v = std::move(motion.v), .a = {}, .truth = {}};
  const Start start{.trajectory = 0, .begin = begin, .steps = steps};
  const Driven driven = drive(model, model.arm.robot, trajectory, {&start, 1});
  const OpenLoop loop{&model.arm, &trajectory, start, driven.z0.front()};
  return std::move(roll_out({&loop, 1}, options).front());
}

}  // namespace fricid::evaluate
