#include "training.hpp"

#include <algorithm>
#include <cmath>

#include "fricid/base/eigen_instances.hpp"
#include "fricid/base/error.hpp"
#include "fricid/dynamics/algorithms.hpp"
#include "support.hpp"

namespace fricid::estimate {
namespace {

constexpr double kResolved = 0.5;       // [rad] phase per step of a spring that steps resolve
constexpr double kLeapTolerance = 0.2;  // share of the gradient that a leap may change

/// (n) stiffness that steps of dt resolve [N m/rad]: sqrt(k/m) dt = 0.5, m = 1/(M^-1)_jj the
/// inertia that joint j shows while the others are free, at the first sample. Gradients through a
/// stiffer spring are those of its chatter.
std::vector<double> resolved_stiffness(const Arm& arm, const signals::Recording& recording,
                                       double dt) {
  const Eigen::ArrayXd k =
      std::pow(kResolved / dt, 2) / mobility(arm.robot, recording, 0).diagonal().array();
  return {k.begin(), k.end()};
}

}  // namespace

std::vector<Window> draw_windows(std::span<const signals::Recording> recordings, const Split& split,
                                 int steps, int count, double from_rest, Rng& rng) {
  std::vector<int> starts;  // admissible, cumulative
  int total = 0;
  for (std::size_t i = 0; i < recordings.size(); ++i)
    starts.push_back(total += std::max(0, split.train_end[i] - steps));
  std::vector<Window> windows;
  const int at_rest = static_cast<int>(std::lround(from_rest * count));
  for (int k = 0; k < at_rest; ++k)
    windows.push_back(
        {static_cast<int>(rng.uniform() * static_cast<double>(recordings.size())), 0});
  for (int k = at_rest; k < count; ++k) {
    const int at = std::min(static_cast<int>(rng.uniform() * total), total - 1);
    const auto i = std::upper_bound(starts.begin(), starts.end(), at) - starts.begin();
    windows.push_back(
        {static_cast<int>(i), at - (i > 0 ? starts[static_cast<std::size_t>(i) - 1] : 0)});
  }
  return windows;
}

Eigen::MatrixXd mobility(const dynamics::RobotModel& robot, const signals::Recording& recording,
                         int row) {
  const auto n = static_cast<std::size_t>(robot.n());
  dynamics::Workspace<double> ws(robot);
  Eigen::MatrixXd M(robot.n(), robot.n());
  dynamics::crba<double>(robot, ws, view(robot.pi), {recording.wide.q.row(row).data(), n},
                         {M.data(), n * n});
  return M.inverse();
}

StepOptions longest_leap(const MultiStepOptions& options,
                         const std::function<Eigen::VectorXd(StepOptions)>& gradient) {
  const Eigen::VectorXd wanted = gradient(options.judge);
  StepOptions step = options.step;
  for (; step.leap > 1; step.leap /= 2)
    if ((gradient(step) - wanted).norm() < kLeapTolerance * wanted.norm()) break;
  return step;
}

WindowSetup set_up_windows(const Arm& start, std::span<const signals::Recording> recordings,
                           const MultiStepOptions& options) {
  const double dt = recordings.front().dt;
  WindowSetup setup{
      .steps = static_cast<int>(std::lround(options.window_s / dt)),
      .split = split_recordings(recordings, options.hold_out),
      .coordinates = {.rigid_body = options.rigid_body, .torque_scale = options.torque_scale}};
  for (std::size_t i = 0; i < recordings.size(); ++i)
    if (setup.split.train_end[i] < 2 * setup.steps)
      throw UserError("{}: {} samples are too few for windows of {} s", recordings[i].log.name,
                      recordings[i].length(), options.window_s);
  setup.coordinates.stiffest = resolved_stiffness(start, recordings.front(),
                                                  dt * options.judge.leap / options.judge.substeps);
  setup.coordinates.limits = options.limits;
  return setup;
}

}  // namespace fricid::estimate
