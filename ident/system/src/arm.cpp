#include "fricid/system/arm.hpp"

#include "fricid/base/error.hpp"

namespace fricid {
namespace {

template <class S, class Range>
std::vector<S> broadcast(const Range& values) {
  std::vector<S> lanes;
  lanes.reserve(static_cast<std::size_t>(values.size()));
  for (const double value : values) lanes.push_back(S(value));
  return lanes;
}

}  // namespace

template <class S>
ArmStepper<S>::ArmStepper(const Arm& arm, StepOptions options)
    : arm_(arm),
      options_(options),
      ws_(arm.robot),
      pi_(broadcast<S>(arm.robot.pi)),
      theta_(broadcast<S>(arm.friction.theta)) {
  const int n = arm.robot.n();
  if (arm.friction.model.joint_count() != n)
    throw UserError("friction has {} joints, the robot has {}", arm.friction.model.joint_count(),
                    n);
  if (options.substeps < 1)
    throw UserError("substeps: found {}, allowed 1 or more", options.substeps);
  if (options.leap < 1 || options.substeps % options.leap != 0)
    throw UserError("leap: found {}, allowed a divisor of substeps {}", options.leap,
                    options.substeps);
  const auto size = static_cast<std::size_t>(n);
  tau_f_.resize(size);
  net_.resize(size);
  a_.resize(size);
  correction_.resize(size);
  in_.resize(size);
}

template <class S>
void ArmStepper<S>::set_inputs(std::span<const S> tau, std::span<const S> temperature,
                               std::span<const S> q, std::span<const S> v) {
  for (std::size_t j = 0; j < in_.size(); ++j) in_[j] = {q[j], v[j], tau[j], temperature[j]};
}

template <class S>
void ArmStepper<S>::friction_torque(std::span<const S> tau, std::span<const S> temperature,
                                    std::span<const S> q, std::span<const S> v,
                                    std::span<const S> z, std::span<S> tau_f) {
  set_inputs(tau, temperature, q, v);
  arm_.friction.model.template torque<S>(theta_, in_, z, tau_f);
}

/// Moves q and z by h at constant velocity; leaves in_ at the new position.
template <class S>
void ArmStepper<S>::drift(double h, std::span<S> q, std::span<const S> v, std::span<S> z) {
  const S lane_h(h);
  for (std::size_t j = 0; j < in_.size(); ++j) {
    q[j] += lane_h * v[j];
    in_[j].q = q[j];
    in_[j].v = v[j];
  }
  arm_.friction.model.template step<S>(theta_, in_, h, z);
}

/// a_ at (q, v, z) = in_, friction at the velocity `ahead` [s] later.
template <class S>
void ArmStepper<S>::acceleration(std::span<const S> tau, double ahead, std::span<const S> q,
                                 std::span<const S> v, std::span<const S> z) {
  const friction::RobotFriction& friction = arm_.friction.model;
  friction.template torque<S>(theta_, in_, z, tau_f_);
  for (std::size_t j = 0; j < net_.size(); ++j) net_[j] = tau[j] - tau_f_[j];
  dynamics::forward_dynamics<S>(arm_.robot, ws_, pi_, q, v, net_, a_);
  if (ahead == 0) return;

  for (std::size_t j = 0; j < in_.size(); ++j) in_[j].v = v[j] + S(ahead) * a_[j];
  friction.template torque<S>(theta_, in_, z, net_);
  for (std::size_t j = 0; j < net_.size(); ++j) net_[j] = tau_f_[j] - net_[j];
  dynamics::solve_with_last_factor<S>(arm_.robot, ws_, net_, correction_);
  for (std::size_t j = 0; j < a_.size(); ++j) a_[j] += correction_[j];
}

template <class S>
void ArmStepper<S>::step(std::span<const S> tau, std::span<const S> temperature, double dt,
                         std::span<S> q, std::span<S> v, std::span<S> z) {
  const double h = dt / options_.substeps, H = h * options_.leap;
  const double before = (H - h) / 2, after = H - before;
  set_inputs(tau, temperature, q, v);
  for (int s = 0; s < options_.substeps; s += options_.leap) {
    if (options_.leap > 1) drift(before, q, v, z);
    acceleration(tau, before, q, v, z);
    for (std::size_t j = 0; j < a_.size(); ++j) v[j] += S(H) * a_[j];
    drift(after, q, v, z);
  }
}

template class ArmStepper<double>;
template class ArmStepper<PackD>;
template class ArmStepper<PackF>;

}  // namespace fricid
