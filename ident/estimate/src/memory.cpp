#include "fricid/estimate/memory.hpp"

#include <algorithm>
#include <cmath>
#include <thread>

#include "fricid/base/limits.hpp"
#include "fricid/estimate/fit.hpp"
#include "fricid/friction/sum.hpp"
#include "support.hpp"

namespace fricid::estimate {
namespace {

constexpr double kNumber = sizeof(double);
constexpr double kCurvatureBatches = 20;  // that Gauss-Newton holds at once
constexpr double kLeaps = 4;              // of the integrator per sample

friction::RobotFriction friction_of(const ModelOptions& options, int n) {
  const auto joints = static_cast<std::size_t>(n);
  if (options.laws.empty() && friction::is_robot_law(options.law))
    return friction::RobotFriction(std::vector<friction::JointSpec>(joints),
                                   {options.law, options.elements, options.n_z});
  const bool sum = options.laws.empty() && options.law == friction::kLvm;
  return friction::RobotFriction(std::vector<friction::JointSpec>(
      joints,
      sum ? friction::lvm_sum({.network = friction::kNetworkUnits}) : joint_spec_of(options)));
}

}  // namespace

double memory_of_filter(int particles, int states) {
  return kNumber * particles * (2.0 * states + 2);
}

double memory_of_fit(const ModelOptions& options, const dynamics::RobotModel& robot,
                     const TrainingSize& size, int jobs) {
  const friction::RobotFriction friction = friction_of(options, robot.n());
  const double parameters = robot.parameter_count() + friction.parameter_count();
  const Method method = options.method.value_or(Method::kConventional);
  const int states = 2 * robot.n() + friction.state_size();
  const double threads =
      jobs > 0 ? jobs : static_cast<double>(std::max(1u, std::thread::hardware_concurrency()));
  if (method == Method::kEm) {
    // the history of a filter keeps about sqrt(2 T) steps, per thread; paths are kept whole
    const double steps = std::ceil(std::sqrt(2 * size.longest));
    const double filters = threads * 1.5 * steps * memory_of_filter(options.em.particles, states);
    const double paths = kNumber * options.em.paths * size.samples * states;
    return filters + paths + kNumber * options.em.batch * (states + parameters);
  }
  const auto batch = [&](double count, double window_s, double copies) {
    const double steps = std::min(window_s * size.rate_hz, size.longest);
    return kNumber * count * (copies * parameters + kLeaps * steps * states);
  };
  double bytes = 0;
  if (method == Method::kMultiStep || method == Method::kJoint)
    bytes += batch(options.train.batch, options.train.window_s, kCurvatureBatches + 2);
  if (method == Method::kTorque ||
      (method == Method::kMultiStep && friction::is_robot_law(options.law)))
    bytes = std::max(bytes, batch(options.torque.batch, options.torque.window_s, 2));
  return bytes;
}

void require_memory_of_fit(const ModelOptions& options, const dynamics::RobotModel& robot,
                           const TrainingSize& size, int jobs, std::string_view where) {
  require_memory(memory_of_fit(options, robot, size, jobs), where,
                 "the fit of model " + options.name);
}

}  // namespace fricid::estimate
