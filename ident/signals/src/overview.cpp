#include "fricid/signals/overview.hpp"
#include "fricid/base/not_finite.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

namespace fricid::signals {
namespace {

constexpr double kMedianToSd = 1.4826;  // sd over median of |x|, x ~ N(0, sd)
constexpr double kGain = 70;            // 1 + 16 + 36 + 16 + 1
constexpr double kTurn = 20;            // of the noise: smaller turns may be noise

}  // namespace

double noise_of_differences(const Eigen::VectorXd& x) {
  std::vector<double> differences;
  for (Eigen::Index k = 0; k + 4 < x.size(); ++k) {
    const double d = x[k] - 4 * x[k + 1] + 6 * x[k + 2] - 4 * x[k + 3] + x[k + 4];
    if (std::isfinite(d)) differences.push_back(std::abs(d));
  }
  if (differences.empty()) return kNan;
  const auto middle = differences.begin() + std::ssize(differences) / 2;
  std::nth_element(differences.begin(), middle, differences.end());
  return kMedianToSd * *middle / std::sqrt(kGain);
}

JointOverview overview(const Dataset& log, int joint) {
  const Eigen::VectorXd q = log.q.col(joint), tau = log.tau.col(joint);
  JointOverview found{
      .low = kInfinity, .high = -kInfinity, .torque_rms = kNan, .noise = noise_of_differences(q)};
  double squares = 0, direction = 0, turn = q[0];
  int torques = 0;
  for (Eigen::Index k = 0; k < q.size(); ++k) {
    found.missing += !std::isfinite(q[k]) || !std::isfinite(tau[k]);
    if (std::isfinite(tau[k])) {
      squares += tau[k] * tau[k];
      found.torque_peak = std::max(found.torque_peak, std::abs(tau[k]));
      ++torques;
    }
    if (!std::isfinite(q[k])) continue;
    found.low = std::min(found.low, q[k]);
    found.high = std::max(found.high, q[k]);
    if (k >= 2 && std::isfinite(q[k - 2]))
      found.fastest = std::max(found.fastest, std::abs(q[k] - q[k - 2]) / (2 * log.dt()));
    // a reversal: away from the last extreme by more than the noise, against the last direction
    if (direction * (q[k] - turn) >= 0) turn = direction == 0 ? turn : q[k];
    if (std::abs(q[k] - turn) > kTurn * found.noise) {
      const double now = q[k] > turn ? 1 : -1;
      if (direction != 0 && now != direction) ++found.reversals;
      direction = now;
      turn = q[k];
    }
  }
  if (torques > 0) found.torque_rms = std::sqrt(squares / torques);
  return found;
}

Eigen::VectorXd slope(const Eigen::VectorXd& x, const Eigen::VectorXd& t) {
  Eigen::VectorXd v(x.size());
  for (Eigen::Index k = 0; k < v.size(); ++k) {
    const Eigen::Index a = std::max<Eigen::Index>(k - 1, 0),
                       b = std::min<Eigen::Index>(k + 1, v.size() - 1);
    v[k] = (x[b] - x[a]) / (t[b] - t[a]);
  }
  return v;
}

}  // namespace fricid::signals
