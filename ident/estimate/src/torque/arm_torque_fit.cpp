#include "fricid/estimate/torque/arm_torque_fit.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>

#include "fricid/base/parallel.hpp"
#include "friction/ripple_search.hpp"
#include "rigid_body/regression.hpp"
#include "support.hpp"
#include "torque/arm_torque_problem.hpp"

namespace fricid::estimate {
namespace {

constexpr double kLongestStep = 1;   // of one iteration in any coordinate
constexpr double kFirstGain = 1e-2;  // smallest gain of a pass that another follows

/// Where theta has ripples without amplitude.
std::vector<std::size_t> unknown_ripples(const friction::Friction& friction) {
  std::vector<std::size_t> terms = ripple_terms(friction.model);
  std::erase_if(terms, [&](std::size_t i) { return friction.theta[ripple_amplitude(i)] != 0; });
  return terms;
}

/// Looks for ripples in what the arm leaves of the torque.
void find_ripples(const ArmTorqueData& data, const std::vector<std::size_t>& terms,
                  WaveSearch waves, Arm& arm, int jobs) {
  const FrictionTorques target = friction_target(arm.robot, arm.robot.pi, data.recordings(), jobs);
  const std::vector<JointModel> models = joint_models(arm.friction.model);
  parallel_for(data.n(), jobs, [&](int j) {
    const JointModel& joint = models[static_cast<std::size_t>(j)];
    std::vector<std::size_t> own;
    for (const std::size_t term : terms)
      if (term >= joint.begin && term < joint.begin + joint.size) own.push_back(term - joint.begin);
    if (own.empty()) return;
    const JointFrictionData left(data.recordings(), target, j, data.cutoff_hz());
    seed_ripples(left, joint.one, own, waves == WaveSearch::kAll,
                 std::span(arm.friction.theta).subspan(joint.begin, joint.size));
  });
}

}  // namespace

ArmTorqueFit fit_arm_torque(const ArmTorqueData& data, const Arm& start,
                            const ArmTorqueOptions& options, int jobs) {
  const auto begin = std::chrono::steady_clock::now();
  ArmTorqueFit fit;
  fit.arm = start;
  bool converged = false;
  const std::vector<std::size_t> sought = options.waves != WaveSearch::kNone
                                              ? unknown_ripples(start.friction)
                                              : std::vector<std::size_t>();
  const int passes = sought.empty() ? 1 : 2;
  for (int pass = 0; pass < passes; ++pass) {
    const bool before = pass + 1 < passes;
    const bool is_rough = before || options.smallest_gain >= kFirstGain;
    if (passes > 1 && !before) find_ripples(data, sought, options.waves, fit.arm, jobs);
    CoordinateOptions frame = options.coordinates;
    if (before)
      for (const std::size_t term : sought) frame.limits.push_back({ripple_amplitude(term), 0, 0});
    const ArmCoordinates coordinates(fit.arm, frame);
    ArmPoint point(coordinates, fit.arm);
    point.move_to(point.c());
    ArmTorqueProblem problem(data, point, options, jobs);
    const optimise::Minimum found = optimise::damped_least_squares(
        [&](const Eigen::VectorXd& c, double value) { return problem.linearise(c, value); },
        [&](const Eigen::VectorXd& c) { return problem.value(c); }, coordinates.box(),
        {point.c(), std::numeric_limits<double>::quiet_NaN()},
        {.damping = {.longest = kLongestStep,
                     .keep_direction = true,
                     .ridge = kStepRidge,
                     .attempts = 8,
                     .lessen = 10,
                     .least = 1e-9,
                     .most = 1e8,
                     .hold_at_bounds = true},
         .iterations = options.iterations,
         .smallest_gain = before ? kFirstGain : options.smallest_gain,
         .refresh = [&] { return !is_rough && problem.forget_slopes(); }});
    point.move_to(found.c);
    fit.arm = point.arm();
    converged = found.converged;
  }
  fit.sigma.resize(data.n());
  for (int j = 0; j < data.n(); ++j)
    fit.sigma[j] = std::sqrt(data.residual(fit.arm, j).squaredNorm() /
                             std::max<double>(1, static_cast<double>(data.joint(j).tau.size())));
  const bool finite = fit.sigma.allFinite() && fit.arm.robot.pi.allFinite();
  fit.outcome = !finite     ? Outcome::kFailed
                : converged ? Outcome::kConverged
                            : Outcome::kIterationLimit;
  fit.message = finite ? "friction and rigid body fitted together" : "no finite prediction";
  fit.seconds = seconds_since(begin);
  return fit;
}

}  // namespace fricid::estimate
