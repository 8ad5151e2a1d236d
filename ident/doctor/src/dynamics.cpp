#include <algorithm>
#include <cmath>

#include "sight.hpp"

namespace fricid::doctor {
namespace {

constexpr int kSamples = 1500;
constexpr double kWindow = 0.03;  // [s] half of that of the local fits

}  // namespace

void check_velocity(const data::Dataset& d, Findings& findings) {
  constexpr double kFactor = 0.1, kRest = 0.1;
  constexpr double kResting = 1e-3;  // [rad/s]
  if (d.v.size() == 0) return;
  const Motion motion = local_motion(d, kSamples, kWindow, 0);
  for (int j = 0; j < d.n(); ++j) {
    const bool stuck = std::any_of(findings.begin(), findings.end(), [j](const Finding& f) {
      return f.kind == FindingKind::kStuck && f.joint == j;
    });
    if (stuck) continue;
    const auto [dot, slope, logged] =
        compare_velocity(motion, j, [&](int k) { return local_fit(d.v, j, k, motion.half).c0; });
    if (!(slope > kResting * kResting * motion.length())) continue;
    const double factor = dot / slope;
    const double rest = logged > 0 ? 1 - dot * factor / logged : 1;
    if (std::abs(factor - 1) < kFactor && rest < kRest) continue;
    findings.push_back({.kind = FindingKind::kVelocity,
                        .signal = "v",
                        .joint = j,
                        .begin_s = d.t[0],
                        .end_s = d.t[d.length() - 1],
                        .size = factor,
                        .unit = "times the derivative of q"});
  }
}

void check_dynamics(const data::Dataset& d, const dynamics::RobotModel* robot, Findings& findings) {
  data::Dataset slow = d;
  const int half = std::max(1, static_cast<int>(std::lround(kSmoothing / d.dt())));
  slow.q = smooth(d.q, half);
  slow.tau = smooth(d.tau, half);
  const int margin = static_cast<int>(std::ceil(kLatest / d.dt())) + 2;
  const Motion motion = local_motion(slow, kSamples, kWindow, margin);
  if (motion.length() < 20 * d.n()) return;
  Sight sight = see(slow, robot, motion);
  const std::size_t before = findings.size();
  undo_degrees(d, robot, motion, sight, findings);
  undo_mistakes(d, robot, motion, sight, findings);
  // Of a log whose columns are in doubt the delay means nothing.
  if (robot && findings.size() == before) check_delay(d, *robot, motion, sight, findings);
}

}  // namespace fricid::doctor
