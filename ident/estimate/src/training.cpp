#include "training.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "fricid/dynamics/algorithms.hpp"
#include "support.hpp"

namespace fricid::estimate {

double training_schedule(int iteration, int iterations) {
  const double done = static_cast<double>(iteration) / iterations;
  return done < 0.6 ? 1 : done < 0.85 ? 0.3 : 0.1;
}

std::vector<Window> draw_windows(std::span<const Recording> recordings, const Split& split,
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

double shorten_gradient(double length, int step, double& mean_length) {
  constexpr double kClip = 3, kMemory = 0.95;
  const double share = step > 1 && length > kClip * mean_length ? kClip * mean_length / length : 1;
  mean_length = step == 1 ? length : kMemory * mean_length + (1 - kMemory) * share * length;
  return share;
}

Eigen::VectorXd mobility(const dynamics::RobotModel& robot, const Recording& recording, int row) {
  const auto n = static_cast<std::size_t>(robot.n());
  dynamics::Workspace<double> ws(robot);
  Eigen::MatrixXd M(robot.n(), robot.n());
  dynamics::crba<double>(robot, ws, view(robot.pi), {recording.q.row(row).data(), n},
                         {M.data(), n * n});
  return M.inverse().diagonal();
}

}  // namespace fricid::estimate
