#include "fricid/viewer/live_arm.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "fricid/dynamics/algorithms.hpp"
#include "fricid/system/arm.hpp"

namespace fricid::viewer {
namespace {

// The joints that are held: stiff, but softer than the sample rate allows.
constexpr double kBandwidthHz = 6, kDamping = 0.9;
constexpr double kReturn = 0.5;  // time constant of the way back [s]

// The swing.
constexpr double kSwing = 2 * std::numbers::pi * 0.25;  // [rad/s]
constexpr double kLag = 0.9;                            // from joint to joint [rad]
constexpr double kSwingFade = 1;                        // [s]
constexpr double kLimitShare = 0.3;                     // of position box and velocity limit
constexpr double kBoxShare = 0.9;    // of the limits, where the scene gives no box
constexpr double kMostSwing = 0.35;  // [rad or m]

std::span<const double> parameters_of(const dynamics::RobotModel& robot) {
  return {robot.pi.data(), static_cast<std::size_t>(robot.pi.size())};
}

}  // namespace

LiveArm::LiveArm(const sim::MujocoArm& arm, const scene::Problem& problem,
                 friction::Friction friction)
    : arm_(arm),
      problem_(problem),
      friction_(std::move(friction)),
      dt_(1 / problem.scene.sensors.rate_hz),
      steps_(sim::steps_per_sample(dt_, arm.step())),
      plant_(std::make_unique<sim::Plant>(arm, problem.robot, friction_)),
      middle_(problem.scene.excitation.centre) {
  const auto& joints = problem.robot.joints;
  const auto& half_range = problem.scene.excitation.half_range;
  for (std::size_t j = 0; j < joints.size(); ++j) {
    const dynamics::Joint& joint = joints[j];
    const bool limited = std::isfinite(joint.lower + joint.upper);
    if (middle_.size() == j) middle_.push_back(limited ? (joint.lower + joint.upper) / 2 : 0);
    double amplitude = kMostSwing;
    if (!half_range.empty())
      amplitude = std::min(amplitude, kLimitShare * half_range[j]);
    else if (limited)
      amplitude = std::min(amplitude, kLimitShare * kBoxShare * (joint.upper - joint.lower) / 2);
    if (joint.velocity > 0) amplitude = std::min(amplitude, kLimitShare * joint.velocity / kSwing);
    amplitude_.push_back(amplitude);
  }
  reset();
}

void LiveArm::reset() {
  const auto n = static_cast<std::size_t>(arm_.n());
  state_ = {middle_, std::vector<double>(n),
            std::vector<double>(static_cast<std::size_t>(plant_->state_size()))};
  plant_->set_state(state_);
  t_ = owed_ = swing_share_ = 0;
  away_.assign(n, 0);
  history_.clear();
}

void LiveArm::advance(double seconds) {
  owed_ = std::min(owed_ + seconds, kMostPerCall);
  for (; owed_ >= dt_ * (1 - 1e-9); owed_ -= dt_) step();
}

void LiveArm::step() {
  // the holding controller ignores coupled motors
  dynamics::RobotModel robot = problem_.robot;
  robot.couplings.clear();
  const auto n = static_cast<std::size_t>(arm_.n());
  dynamics::Workspace<double> ws(robot);
  std::vector<double> rest(n), tau(n), M(n * n);
  dynamics::rnea<double>(robot, ws, parameters_of(robot), state_.q, rest, rest, tau);
  dynamics::crba<double>(robot, ws, parameters_of(robot), state_.q, M);
  const double w = 2 * std::numbers::pi * kBandwidthHz;
  const double fade = dt_ / kSwingFade;
  swing_share_ = std::clamp(swing_share_ + (swings ? fade : -fade), 0.0, 1.0);
  const double swing = swing_share_ * swing_share_ * (3 - 2 * swing_share_);
  for (std::size_t j = 0; j < n; ++j) {
    const double goal =
        middle_[j] + swing * amplitude_[j] * std::sin(kSwing * t_ - kLag * static_cast<double>(j));
    if (!swings && static_cast<int>(j) == push.joint) {
      away_[j] = state_.q[j] - goal;
      tau[j] +=
          push.torque + push.amplitude * std::sin(2 * std::numbers::pi * push.frequency_hz * t_);
    } else {
      away_[j] *= std::exp(-dt_ / kReturn);
      tau[j] +=
          M[j * n + j] * (w * w * (goal + away_[j] - state_.q[j]) - 2 * kDamping * w * state_.v[j]);
    }
  }
  const std::vector<double> temperature(n, kRoomTemperature);
  plant_->hold(tau, temperature, steps_);
  const auto tau_f = plant_->tau_f();
  history_.push_back({t_, state_.q, state_.v, tau, {tau_f.begin(), tau_f.end()}, state_.z});
  while (history_.front().t < t_ - kHistory) history_.pop_front();
  state_ = plant_->state();
  t_ += dt_;
}

void LiveArm::set_parameter(int index, double value) {
  const auto i = static_cast<std::size_t>(index);
  const friction::ParameterInfo& info = friction_.model.parameters()[i].info;
  friction_.theta[i] = std::clamp(value, info.lower, info.upper);
  plant_ = std::make_unique<sim::Plant>(arm_, problem_.robot, friction_);
  plant_->set_state(state_);
}

}  // namespace fricid::viewer
