#include "fricid/estimate/contact/contact_log.hpp"

#include <cmath>
#include <optional>

#include "fricid/base/error.hpp"
#include "fricid/base/progress.hpp"
#include "fricid/estimate/contact/momentum_observer.hpp"
#include "fricid/estimate/online/online_log.hpp"
#include "fricid/system/transmission.hpp"

namespace fricid::estimate {
namespace {

/// Missing values are those before; 0 at the start.
void hold_missing(RowMatrix& x) {
  for (Eigen::Index k = 0; k < x.rows(); ++k)
    for (Eigen::Index j = 0; j < x.cols(); ++j)
      if (!std::isfinite(x(k, j))) x(k, j) = k > 0 ? x(k - 1, j) : 0;
}

}  // namespace

data::ContactSignals observe_log(const data::ModelFile& model, const data::Dataset& at_joints,
                                 const ObserverOptions& options) {
  const int n = model.arm.robot.n(), T = at_joints.length();
  if (at_joints.n() != n)
    throw UserError("{}: {} joints, model {} has {}", at_joints.name, at_joints.n(), model.name, n);
  const Transmission motors(model.arm.robot);
  data::Dataset log = motors.to_motors(at_joints);
  hold_missing(log.q);
  hold_missing(log.tau);
  if (log.temperature.size() == 0) log.temperature.setConstant(T, n, kRoomTemperature);
  hold_missing(log.temperature);

  data::ContactSignals out;
  out.joint_names = log.joint_names;
  out.model = model.name;
  out.log = log.name;
  out.t = log.t;
  out.tau_ext.setZero(T, n);
  out.tau_f.setZero(T, n);
  MomentumObserver observer(model.arm, log.dt(), options.bandwidth_hz);
  std::optional<OnlineEstimator> filter;
  if (options.particles > 0)
    filter.emplace(begin_online(
        model, log.q.row(0), log.rate_hz,
        {.particles = options.particles, .step = {8, 4}, .seed = options.seed}, log.name));
  const auto row = [n](const RowMatrix& x, int k) {
    return std::span<const double>(x.row(k).data(), static_cast<std::size_t>(n));
  };
  for (int k = 0; k < T; ++k) {
    if (k % 1000 == 0) throw_if_stopped();
    const auto held = row(log.tau, std::max(0, k - 1)), q = row(log.q, k),
               temperature = row(log.temperature, k);
    std::span<const double> r;
    if (filter) {
      const Eigen::VectorXd& tau_f = filter->estimate().tau_f;  // at the sample before
      r = observer.step_with(held, q, {tau_f.data(), static_cast<std::size_t>(n)});
      if (k > 0) filter->step(held, q, temperature);
    } else {
      r = observer.step(held, q, temperature);
    }
    std::copy(r.begin(), r.end(), out.tau_ext.row(k).data());
    std::copy(observer.friction().begin(), observer.friction().end(), out.tau_f.row(k).data());
  }
  if (motors.coupled()) {
    out.tau_ext = motors.torque_to_joints(out.tau_ext);
    out.tau_f = motors.torque_to_joints(out.tau_f);
  }
  return out;
}

}  // namespace fricid::estimate
