#include "fricid/estimate/rigid_body/least_squares.hpp"

#include <algorithm>
#include <chrono>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "fricid/base/unit_of_joint.hpp"
#include "fricid/data/fit_file.hpp"
#include "fricid/dynamics/algorithms.hpp"
#include "rigid_body/solve.hpp"

namespace fricid::estimate {
namespace {

constexpr double kLeastUsual = 1. / 3;  // of a guessed armature: some gears have as little

/// Why the data alone do not determine the base parameters; empty when they do.
std::string undetermined(const RigidBodyFit& fit) {
  if (fit.outcome == Outcome::kConverged) return {};
  return fit.outcome == Outcome::kIllConditioned
             ? fmt::format("condition {:.3g} without it", fit.condition)
             : fit.message;
}

/// See `RigidBodyFit::slower`. The usual speed is lowered as a matter of course.
std::string slower_than_asked(const dynamics::RobotModel& robot, const RigidBodyOptions& options,
                              const std::vector<double>& least_speed) {
  if (options.min_speed_rad_s == RigidBodyOptions{}.min_speed_rad_s) return {};
  std::vector<std::string> slower;
  for (std::size_t j = 0; j < least_speed.size(); ++j)
    if (const dynamics::Joint& joint = robot.joints[j]; least_speed[j] < options.min_speed_rad_s)
      slower.push_back(fmt::format("{:.2g} {} of {}", least_speed[j],
                                   unit_of_joint("rad/s", slides(joint)), joint.name));
  if (slower.empty()) return {};
  return fmt::format("min_speed_rad_s = {:.3g} is too fast for the motion: rows enter from {}",
                     options.min_speed_rad_s, fmt::join(slower, ", "));
}

}  // namespace

RowMatrix rigid_body_torque(const dynamics::RobotModel& robot, const Eigen::VectorXd& pi,
                            const signals::Recording& sequence) {
  const auto n = static_cast<std::size_t>(robot.n());
  dynamics::Workspace<double> ws(robot);
  RowMatrix tau(sequence.length(), sequence.n());
  for (int k = 0; k < sequence.length(); ++k) {
    const auto row = [&](const RowMatrix& x) {
      return std::span<const double>(x.row(k).data(), n);
    };
    dynamics::rnea<double>(robot, ws, {pi.data(), static_cast<std::size_t>(pi.size())},
                           row(sequence.narrow.q), row(sequence.narrow.v), row(sequence.narrow.a),
                           {tau.row(k).data(), n});
  }
  return tau;
}

bool RigidBodyFit::shows_growth(int joint) const {
  return growth.size() > joint && data::FittedLoadGrowth::is_seen(growth[joint], growth_se[joint]);
}

bool RigidBodyFit::moves_at_one_speed(int joint) const {
  const auto at = static_cast<std::size_t>(joint);
  return at < speeds.size() && speeds[at].is_one();
}

RigidBodyOptions as_needed(RigidBodyOptions options, const RigidBodyFit& fit) {
  options.prior.use = !fit.prior.empty();
  for (const JointInertia& joint : fit.without_inertia)
    options.held_armatures.push_back(joint.joint);
  options.prior_where_needed = false;
  return options;
}

RigidBodyFit rigid_body_least_squares(const dynamics::RobotModel& robot,
                                      std::span<const signals::Recording> sequences,
                                      const RigidBodyOptions& options,
                                      const FrictionTorques* shape) {
  const auto begin = std::chrono::steady_clock::now();
  RigidBodyFit counts;
  const Regression data = stack(robot, sequences, options, shape, counts);
  const NoiseRows noise = draw_noise_rows(robot, sequences, data, options.cutoff_hz);
  RigidBodyOptions used = options;
  RigidBodyFit fit = solve(robot, sequences, data, noise, used, counts);
  std::string why = options.prior.use ? "asked for" : "";
  if (options.prior_where_needed && !options.prior.use) {
    why = undetermined(fit);
    used.prior.use = !why.empty();
    if (used.prior.use) fit = solve(robot, sequences, data, noise, used, counts);
  }
  if (const std::vector<JointInertia> without = fit.without_inertia;
      options.prior_where_needed && !without.empty()) {
    dynamics::RobotModel held = robot;
    for (const JointInertia& joint : without) {
      used.held_armatures.push_back(joint.joint);
      if (std::ranges::count(options.guesses.armature, joint.joint) > 0)
        held.pi[held.armature_begin() + joint.joint] *= kLeastUsual;
    }
    fit = solve(held, sequences, data, noise, used, counts);
    fit.without_inertia = without;
  }
  fit.prior = why;
  fit.slower = slower_than_asked(robot, options, fit.least_speed);
  fit.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  return fit;
}

}  // namespace fricid::estimate
