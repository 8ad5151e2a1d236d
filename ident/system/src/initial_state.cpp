#include "fricid/system/initial_state.hpp"

#include <algorithm>
#include <cmath>

#include "fricid/dynamics/algorithms.hpp"

namespace fricid {
namespace {

constexpr double kRestSpeed = 0.02;      // a joint slower than this is at rest [rad/s]
constexpr double kApproach = 0.5;        // speed of the approach [rad/s]
constexpr double kPeriod = 4e-3;         // of the steps while sliding [s]
constexpr int kFast = 100, kSlow = 250;  // steps of sliding at kApproach and at kRestSpeed
constexpr double kFarPeriod = 0.5;       // of the steps while sliding on at kRestSpeed [s]
constexpr int kFar = 500;                // such steps, 5 rad together
constexpr double kClose = 1e-3;          // share of the torque that may be lacking
constexpr double kCreepSpeed = 2e-4;     // [rad/s]
constexpr double kCreepPeriod = 0.2;     // [s]
constexpr int kCreep = 250;              // such steps, 10 mrad together
constexpr double kBackSpeed = 2e-3;      // [rad/s]
constexpr double kFirstBack = 1e-6;      // of the way back [rad]
constexpr double kGrowth = 1.05;         // of each piece of it over the one before
constexpr int kBack = 160;               // pieces, about 50 mrad together
constexpr double kTorqueSpan = 0.02;     // over which the first torque is averaged [s]

}  // namespace

std::vector<double> state_at_torque(const friction::Friction& friction,
                                    std::span<const friction::Input<double>> in,
                                    std::span<const double> tau_f) {
  const friction::RobotFriction& model = friction.model;
  const std::size_t n = in.size();
  std::vector<double> z(static_cast<std::size_t>(model.state_size()), 0.0);
  const int of_joints = model.state_begin(model.joint_count());
  if (of_joints == 0) return z;
  std::vector<friction::Input<double>> driven(in.begin(), in.end());
  std::vector<double> torque(n), last(n);

  const auto rests = [&](std::size_t j) { return std::abs(in[j].v) <= kRestSpeed; };
  const auto direction = [&](std::size_t j) { return tau_f[j] < 0 ? -1.0 : 1.0; };
  for (int k = 0; k < kFast + kSlow; ++k) {
    for (std::size_t j = 0; j < n; ++j)
      if (rests(j)) driven[j].v = direction(j) * (k < kFast ? kApproach : kRestSpeed);
    model.step<double>(friction.theta, driven, kPeriod, z);
  }

  std::vector<char> done(n);
  const auto excess = [&](std::size_t j, const std::vector<double>& tau) {
    return direction(j) * (tau[j] - tau_f[j]);
  };

  // a joint that holds more has slid on, until cables are bent, and crept to rest
  const auto slide_on = [&](int steps, double period, double speed) {
    for (int k = 0; k < steps; ++k) {
      model.torque<double>(friction.theta, in, z, last);
      for (std::size_t j = 0; j < n; ++j) {
        done[j] = done[j] || !rests(j) || excess(j, last) > -kClose * std::abs(tau_f[j]);
        if (rests(j)) driven[j].v = done[j] ? 0 : direction(j) * speed;
      }
      if (std::count(done.begin(), done.end(), 0) == 0) return;
      model.step<double>(friction.theta, driven, period, z);
    }
  };
  slide_on(kFar, kFarPeriod, kRestSpeed);
  slide_on(kCreep, kCreepPeriod, kCreepSpeed);

  // move back until the torque of a joint equals tau_f, within the last piece by the secant
  model.torque<double>(friction.theta, in, z, last);
  for (std::size_t j = 0; j < n; ++j) done[j] = !rests(j) || excess(j, last) <= 0;
  double piece = kFirstBack;
  for (int k = 0; k < kBack && std::count(done.begin(), done.end(), 0) > 0; ++k, piece *= kGrowth) {
    const std::vector<double> z_last = z;
    const auto go = [&](const std::vector<double>& share) {
      z = z_last;
      for (std::size_t j = 0; j < n; ++j)
        driven[j].v = done[j] ? 0 : -direction(j) * kBackSpeed * share[j];
      model.step<double>(friction.theta, driven, piece / kBackSpeed, z);
      model.torque<double>(friction.theta, in, z, torque);
    };
    std::vector<double> share(n, 1.0);
    go(share);
    std::vector<char> arrived(n);
    for (std::size_t j = 0; j < n; ++j)
      if (!done[j] && excess(j, torque) <= 0) {
        arrived[j] = 1;
        share[j] = excess(j, last) / (excess(j, last) - excess(j, torque));
      }
    if (std::count(arrived.begin(), arrived.end(), 1) > 0) go(share);
    for (std::size_t j = 0; j < n; ++j) done[j] = done[j] || arrived[j];
    last = torque;
  }
  std::fill(z.begin() + of_joints, z.end(), 0.0);
  return z;
}

std::vector<double> initial_friction_state(const Arm& arm, double dt, ConstRowMatrix q,
                                           ConstRowMatrix v, ConstRowMatrix tau,
                                           ConstRowMatrix temperature) {
  const auto n = static_cast<std::size_t>(q.cols());
  const Eigen::Index span = std::clamp<Eigen::Index>(std::lround(kTorqueSpan / dt), 1,
                                                     std::max<Eigen::Index>(1, q.rows() - 1));
  const Eigen::Index last = std::min(span, q.rows() - 1);
  const Eigen::VectorXd q0 = q.row(0), v0 = v.row(0);
  const Eigen::VectorXd a = (v.row(last) - v.row(0)) / (static_cast<double>(span) * dt);
  const Eigen::VectorXd tau0 = tau.topRows(span).colwise().mean();

  dynamics::Workspace<double> ws(arm.robot);
  std::vector<double> rigid(n), tau_f(n);
  const auto view = [](const Eigen::VectorXd& x) {
    return std::span<const double>(x.data(), static_cast<std::size_t>(x.size()));
  };
  dynamics::rnea<double>(arm.robot, ws, view(arm.robot.pi), view(q0), view(v0), view(a), rigid);
  std::vector<friction::Input<double>> in(n);
  for (std::size_t j = 0; j < n; ++j) {
    const auto c = static_cast<Eigen::Index>(j);
    tau_f[j] = tau0[c] - rigid[j];
    in[j] = {q0[c], v0[c], tau0[c], temperature.size() > 0 ? temperature(0, c) : kRoomTemperature};
  }
  return state_at_torque(arm.friction, in, tau_f);
}

}  // namespace fricid
