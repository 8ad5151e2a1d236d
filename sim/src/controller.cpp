#include "fricid/sim/controller.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace fricid::sim {

Controller::Controller(const ControllerOptions& options, const dynamics::RobotModel& robot,
                       double dt)
    : robot_(robot),
      motors_(robot),
      ws_(robot),
      law_(options.kind),
      w_(2 * std::numbers::pi * options.bandwidth_hz),
      zeta_(options.damping),
      integral_s_(options.integral_s),
      model_error_(options.model_error),
      dt_(dt) {
  const auto n = static_cast<std::size_t>(robot.n());
  zero_.assign(n, 0.0);
  integral_.assign(n, 0.0);
  a_.resize(n);
  feedback_.assign(n, 0.0);
  bias_.resize(n);
  M_.resize(n * n);
}

void Controller::torque(const Reference& reference, std::span<const double> q,
                        std::span<const double> v, std::span<double> tau) {
  if (!motors_.coupled()) return torque_at_motors(reference, q, v, tau);
  const auto n = std::ssize(q);
  const Eigen::MatrixXd& C = motors_.inverse();
  const auto at_motors = [&](std::span<const double> x) -> Eigen::VectorXd {
    return C * Eigen::Map<const Eigen::VectorXd>(x.data(), n);
  };
  const Eigen::VectorXd q_m = at_motors(q), v_m = at_motors(v);
  const Eigen::VectorXd q_ref = C * reference.q, v_ref = C * reference.v, a_ref = C * reference.a;
  Eigen::VectorXd tau_m(n);
  torque_at_motors({q_ref, v_ref, a_ref}, {q_m.data(), q.size()}, {v_m.data(), q.size()},
                   {tau_m.data(), q.size()});
  Eigen::Map<Eigen::VectorXd>(tau.data(), n) = C.transpose() * tau_m;
  Eigen::Map<Eigen::VectorXd> feedback(feedback_.data(), n);
  feedback = (C.transpose() * feedback).eval();
}

void Controller::torque_at_motors(const Reference& reference, std::span<const double> q,
                                  std::span<const double> v, std::span<double> tau) {
  const std::size_t n = q.size();
  const std::span<const double> pi{robot_.pi.data(), static_cast<std::size_t>(robot_.pi.size())};
  dynamics::crba<double>(robot_, ws_, pi, q, M_);
  const std::span<const double> velocity = law_ == ControlLaw::kComputedTorque ? v : zero_;
  dynamics::rnea<double>(robot_, ws_, pi, q, velocity, zero_, bias_);

  // acceleration against the errors, per joint
  for (std::size_t j = 0; j < n; ++j) {
    const auto i = static_cast<Eigen::Index>(j);
    const double e = reference.q[i] - q[j], e_dot = reference.v[i] - v[j];
    if (law_ == ControlLaw::kCascade)
      a_[j] = 2 * zeta_ * w_ * (w_ / (2 * zeta_) * e + e_dot + integral_[j] / integral_s_);
    else
      a_[j] = w_ * w_ * e + 2 * zeta_ * w_ * e_dot;
  }

  for (std::size_t j = 0; j < n; ++j) {
    double inertial = 0;
    feedback_[j] = 0;
    if (law_ == ControlLaw::kComputedTorque)
      for (std::size_t i = 0; i < n; ++i) {
        feedback_[j] += M_[j * n + i] * a_[i];
        inertial += M_[j * n + i] * reference.a[static_cast<Eigen::Index>(i)];
      }
    else
      feedback_[j] = M_[j * n + j] * a_[j];
    const double gain = law_ == ControlLaw::kCascade ? 1 + model_error_ : 1;
    const double wanted = gain * bias_[j] + inertial + feedback_[j];
    const double effort = robot_.joints[j].effort;
    const double limit = effort > 0 ? effort : std::numeric_limits<double>::infinity();
    tau[j] = std::clamp(wanted, -limit, limit);

    const auto i = static_cast<Eigen::Index>(j);
    if (std::abs(wanted) <= limit)
      integral_[j] += dt_ * (w_ / (2 * zeta_) * (reference.q[i] - q[j]) + reference.v[i] - v[j]);
  }
}

}  // namespace fricid::sim
