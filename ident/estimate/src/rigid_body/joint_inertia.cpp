#include "rigid_body/joint_inertia.hpp"

#include <algorithm>
#include <vector>

#include "fricid/dynamics/algorithms.hpp"
#include "support.hpp"

namespace fricid::estimate {

Eigen::VectorXd joint_inertia(const dynamics::RobotModel& robot,
                              std::span<const signals::Recording> recordings) {
  constexpr int kSamples = 20;  // of a recording
  const auto n = static_cast<std::size_t>(robot.n());
  dynamics::Workspace<double> ws(robot);
  std::vector<double> M(n * n);
  Eigen::VectorXd sum = Eigen::VectorXd::Zero(robot.n());
  int count = 0;
  for (const signals::Recording& r : recordings)
    for (int k = 0; k < r.length(); k += std::max(1, r.length() / kSamples)) {
      const std::span<const double> q(r.narrow.q.row(k).data(), n);
      dynamics::crba<double>(robot, ws, view(robot.pi), q, M);
      for (std::size_t j = 0; j < n; ++j) sum[static_cast<Eigen::Index>(j)] += M[j * n + j];
      ++count;
    }
  return sum / std::max(1, count);
}

}  // namespace fricid::estimate
